"""Replays: each scene moves on the page, the exact answer with two runs over it, from the store."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.scene import Case, Scene
from plumbob.reports.analyses.replay import observables
from plumbob.reports.analyses.replay.body import body
from plumbob.reports.analyses.replay.capsule import capsule
from plumbob.reports.analyses.replay.cone import cone
from plumbob.reports.analyses.replay.pendulums import companion, pendulum
from plumbob.reports.analyses.replay.picture import Picture, clock
from plumbob.reports.analyses.replay.runs import DEFAULT_STEP, Role, shown_runs, shown_seconds
from plumbob.reports.analyses.replay.samples import Channels, Samples, coded, fine, sampled
from plumbob.reports.view import notation
from plumbob.reports.view.records import Choice, Layer, Replay

PICTURES = MappingProxyType(
    {"capsule": capsule, "cone_pendulum": cone, "free_body": body, "simple_pendulum": pendulum}
)  # by the family of the system
WORDS: Mapping[Role, str] = MappingProxyType(
    {
        "default": "default settings",
        "user": "your settings",
        "recommended": "recommended settings",
        "other": "",
    }
)
Drawn = tuple[Layer, Samples]  # a motion, or a run's deviations from it, with how it is drawn
SMALLER = " but for the step"  # that of the recommended settings beside them
SPEEDS = tuple(
    float(f"{digit}e{exponent}") for exponent in range(-5, 2) for digit in (1, 2, 5)
)  # of replayed time to real time
LASTING = 8.0  # [s] of a replay at the speed that is chosen first
VISIBLE = 0.1  # of the picture: how large the smallest errors are drawn at the largest factor
MOST = 12  # powers of ten of the largest factor
MOMENTS = (0.0, 0.19, 0.38, 0.61, 0.81, 1.0)  # of the replay; unequal, or a swing looks at rest
LARGE = 0.15  # of the picture: how large the first run's largest error is drawn on paper at most


def replay(study: Study, scene: Scene) -> Replay:
    """The replay of a scene: a function of the stored study, which runs no engine."""
    case = case_of(scene)
    seconds = shown_seconds(scene)
    picture = _picture(case, seconds)
    exact = sampled(picture.motion, seconds, picture.angles, picture.smooth)
    runs: list[Drawn] = []
    lacking: list[str] = []
    missing = {  # engines that are not installed: the page says that once
        c.method
        for c in study.convergence
        if c.scene == scene.name and {m.status for m in c.measurements} == {"missing"}
    }
    for shown in shown_runs(StudyPlan(study.profile, study.scenes, study.methods), scene):
        run = study.answer(shown.run) if shown.run in study.extras else None
        name = f"{shown.run.method}, {_step(shown.run.step, shown.control)}"
        if run is None:
            lacking += [name] if shown.run.method not in missing else []
            continue
        samples = Samples(run.times, picture.deviations(run))
        slot = "second" if shown.role == "recommended" or runs else "first"
        words = WORDS[shown.role]
        if shown.role == "default" and shown.run.step != DEFAULT_STEP:
            words += SMALLER
        layer = Layer(slot, name, words, *errors_said(picture, samples.channels))
        runs.append((layer, samples))
    beside: list[Drawn] = []
    if other := companion(scene):
        shape = _picture(other, seconds)
        samples = sampled(shape.motion, seconds, shape.angles, shape.smooth)
        beside.append((Layer("companion", "linear pendulum", "exact, the same start"), samples))
    truth = Layer("exact", "exact answer", ""), exact
    return assembled(scene.name, scene.duration, picture, truth, runs, beside, lacking)


def assembled(
    name: str,
    whole: float,
    picture: Picture,
    exact: Drawn,
    runs: Sequence[Drawn],
    beside: Sequence[Drawn] = (),
    lacking: Sequence[str] = (),
) -> Replay:
    """The replay of a motion of `whole` [s], as far as its samples reach, with runs as deviations
    from it and at most one other motion beside it."""
    seconds = float(exact[1].times[-1])
    coded_layers = [
        _exact(exact[0].slot, exact[1], picture),
        *(_deviating(layer.slot, samples) for layer, samples in runs),
        *(_exact(layer.slot, samples, picture) for layer, samples in beside),
    ]
    data = {
        "kind": picture.kind,
        "seconds": seconds,
        "box": picture.box,
        "size": picture.size,
        "geometry": dict(picture.geometry),
        "charts": [asdict(chart) for chart in picture.charts],
        "smooth": sorted(picture.smooth),
        "layers": coded_layers,
    }
    return Replay(
        name,
        name.replace("/", "-"),
        picture.text,
        seconds,
        whole,
        tuple(layer for layer, _ in (exact, *runs, *beside)),
        tuple(lacking),
        _speeds(seconds),
        _factors(picture, [samples for _, samples in runs]),
        {clock(time): time for time in (seconds * part for part in MOMENTS)},
        magnified(picture, [samples for _, samples in runs]),
        _json(data),
    )


def errors_said(picture: Picture, deviations: Channels) -> tuple[str, str]:
    """The largest error of a run over the replay, and the one at its end, with units."""
    last = {name: values[-1:] for name, values in deviations.items()}
    return picture.largest(deviations), picture.largest(last)


def _picture(case: Case, seconds: float) -> Picture:
    draw = PICTURES.get(case.system.family, observables.chart)
    return draw(case, seconds)


def _exact(role: str, samples: Samples, picture: Picture) -> dict[str, Any]:
    channels = {n: coded(v, n in picture.angles) for n, v in samples.channels.items()}
    return {"role": role, "count": len(samples.times), "channels": channels}


def _deviating(role: str, samples: Samples) -> dict[str, Any]:
    channels = {name: fine(values) for name, values in samples.channels.items()}
    times = fine(samples.times)
    return {"role": role, "count": len(samples.times), "times": times, "channels": channels}


def _step(step: float, control: str) -> str:
    return notation.seconds(step) if control == "step" else notation.step(step, control)


def _speeds(seconds: float) -> tuple[Choice, ...]:
    """Speeds from a fifth of that at which a replay lasts some seconds to ten times that."""
    best = min(SPEEDS, key=lambda speed: abs(math.log(speed * LASTING / seconds)))
    around = [speed for speed in SPEEDS if 0.15 * best < speed < 12.0 * best]
    return tuple(Choice(speed, _speed(speed), speed == best) for speed in around)


def _speed(speed: float) -> str:
    if speed == 1.0:
        return "real time"
    return f"{speed:g} × real time" if speed > 1.0 else f"1/{1.0 / speed:,.0f} of real time"


def _factors(picture: Picture, runs: Sequence[Samples]) -> tuple[int, ...]:
    """Powers of ten by which errors are drawn, up to where the smallest of them are seen."""
    sizes = [float(np.max(picture.deviation(samples.channels))) for samples in runs]
    least = min((size for size in sizes if size > 0.0), default=0.0)
    wanted = math.log10(VISIBLE * picture.size / least) if least else 0.0
    return tuple(10**k for k in range(min(max(math.ceil(wanted), 1), MOST) + 1))


def magnified(picture: Picture, runs: Sequence[Samples]) -> int:
    """The largest power of ten by which the first run's errors can be drawn and stay small in the
    picture; 1 where they are not."""
    largest = float(picture.deviation(runs[0].channels).max()) if runs else 0.0
    factor = 1
    while 0.0 < 10 * factor * largest <= LARGE * picture.size and factor < 10**MOST:
        factor *= 10
    return factor


def _json(data: Mapping[str, Any]) -> str:
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")
