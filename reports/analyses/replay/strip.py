"""Six moments of a replay as still pictures, for paper and for readers without JavaScript."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from plumbob.reports.analyses.replay.picture import Line, Picture, State, clock
from plumbob.reports.analyses.replay.samples import Samples
from plumbob.reports.view.records import Moment, Shape, Strip

MOMENTS = (0.0, 0.19, 0.38, 0.61, 0.81, 1.0)  # of the replay; unequal, or a swing looks at rest
WIDTH = 160.0  # of a picture, in its own units
LARGE = 0.15  # of the picture: how large the first run's largest error is drawn at most
RADII: Mapping[str, float] = MappingProxyType(
    {"exact": 3.0, "first": 5.0, "second": 7.0, "companion": 4.0}
)  # of the marked point


def strip(
    picture: Picture,
    seconds: float,
    exact: Samples,
    runs: Sequence[tuple[str, Samples]],
    beside: Samples | None = None,
) -> Strip:
    """Moments over `seconds` [s] of the exact motion and of `runs`, which are given as deviations
    from it, each with how it is drawn; and of a motion drawn `beside` it."""
    left, right, bottom, top = picture.box
    scale = WIDTH / (right - left)
    factor = magnified(picture, [samples for _, samples in runs])

    def shape(role: str, state: State, time: float) -> Shape:
        x, y = picture.mark(state, time)
        path = "".join(_path(line, left, top, scale) for line in picture.outline(state, time))
        return Shape(
            role, path, round(scale * (x - left), 1), round(scale * (top - y), 1), RADII[role]
        )

    moments = []
    for time in (seconds * part for part in MOMENTS):
        state = at(exact, time)
        shapes = [shape("exact", state, time)]
        for role, samples in runs:
            if factor * _apart(picture, samples, time) < picture.size:
                shapes.append(shape(role, _moved(state, at(samples, time), factor), time))
        if beside:
            shapes.append(shape("companion", at(beside, time), time))
        moments.append(Moment(time, clock(time), tuple(shapes)))
    return Strip(WIDTH, round(scale * (top - bottom), 1), factor, tuple(moments))


def magnified(picture: Picture, runs: Sequence[Samples]) -> int:
    """The largest power of ten by which the first run's errors can be drawn and stay small in the
    picture; 1 where they are not."""
    largest = float(picture.deviation(runs[0].channels).max()) if runs else 0.0
    factor = 1
    while 0.0 < 10 * factor * largest <= LARGE * picture.size and factor < 10**12:
        factor *= 10
    return factor


def at(samples: Samples, time: float) -> dict[str, float]:
    """Channels at `time` [s], interpolated; after the last sample those of the last."""
    return {n: float(np.interp(time, samples.times, v)) for n, v in samples.channels.items()}


def _apart(picture: Picture, samples: Samples, time: float) -> float:
    now = {name: np.array([value]) for name, value in at(samples, time).items()}
    return float(picture.deviation(now)[0])


def _moved(state: State, deviation: Mapping[str, float], factor: int) -> dict[str, float]:
    return {name: value + factor * deviation.get(name, 0.0) for name, value in state.items()}


def _path(line: Line, left: float, top: float, scale: float) -> str:
    """A line as an SVG path, y down, by differences of tenths of a unit, which are short."""
    tenths = np.rint(10.0 * scale * (np.array(line.places) - (left, top)) * (1.0, -1.0))
    (x, y), *moves = (tenths - np.concatenate([np.zeros((1, 2)), tenths[:-1]])).tolist()
    steps = " ".join(f"{dx / 10:g} {dy / 10:g}" for dx, dy in moves).replace(" -", "-")
    return f"M{x / 10:g} {y / 10:g}l{steps}{'z' if line.closed else ''}"
