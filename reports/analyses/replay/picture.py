"""The picture of a system in a replay: channels, geometry, charts, and the outline of a moment."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.replay.samples import Channels
from plumbob.reports.view.notation import number, seconds

Kind = Literal["pendulum", "cone", "capsule", "body", "chart", "geoms"]
Box = tuple[float, float, float, float]  # left, right, bottom, top
MARGIN = 0.08  # of a chart's range, beyond it


@dataclass(frozen=True)
class Chart:
    """A small plot beside the picture: one channel, or more, over another or over time."""

    label: str
    x: str  # "t", or a channel
    y: tuple[str, ...]
    box: Box
    turns: bool = False  # x is an angle that goes round: it is drawn from -pi to pi
    equal: bool = False  # one scale for both axes
    seconds: float = 0.0  # shown around the present; 0: all
    exact_alone: bool = False


@dataclass(frozen=True)
class Picture:
    """How a case is drawn. `motion` gives its channels at times [s], shape (n,); `deviations` what
    a run differs by, at the run's times, in the same channels."""

    kind: Kind
    text: str  # what moves, in a sentence or two
    box: Box  # that the picture shows [m]
    geometry: Mapping[str, Any]  # what the script needs beside that, as JSON
    charts: tuple[Chart, ...]
    angles: frozenset[str]  # channels whose range may be many turns
    smooth: frozenset[str]  # channels that are interpolated by cubics
    size: float  # of a deviation that is as large as the picture: [m], or 1 rad
    motion: Callable[[Array], Channels]
    deviations: Callable[[Trajectory], Channels]
    deviation: Callable[[Channels], Array]  # its magnitude, shape (n,), in the unit of `size`
    largest: Callable[[Channels], str]  # that, in words with units


def observed(
    observe: Callable[[Array], Channels], names: Sequence[str]
) -> tuple[Callable[[Array], Channels], Callable[[Trajectory], Channels]]:
    """The motion that `observe` gives at times [s], and the differences of a run from it, in
    channels that are observables."""

    def motion(times: Array) -> Channels:
        exact = observe(times)
        return {name: exact[name] for name in names}

    def deviations(run: Trajectory) -> Channels:
        exact = motion(run.times)
        return {name: run.observables.get(name, values) - values for name, values in exact.items()}

    return motion, deviations


def around(*values: Array, least: float = 0.0) -> tuple[float, float]:
    """A range with a margin that holds all `values`, `least` wide or more."""
    low, high = (float(f(np.concatenate(values))) for f in (np.min, np.max))
    half = max(0.5 * (high - low), 0.5 * least) or 1.0
    middle = 0.5 * (low + high)
    return middle - (1.0 + 2.0 * MARGIN) * half, middle + (1.0 + 2.0 * MARGIN) * half


def metres(value: float) -> str:
    """A length with a unit that suits it."""
    for unit, size in (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9)):
        if abs(value) >= size:
            return f"{number(value / size)} {unit}"
    return f"{number(value)} m"


def clock(value: float) -> str:
    """A time with a unit that suits it."""
    return seconds(value) if value else "0 s"


def radians(value: float) -> str:
    """An angle with its unit."""
    return f"{number(value)} rad"
