"""Replays: each scene moves on the page, the exact answer with two runs over it, from the store."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of, system_of
from plumbob.models.scene import Case, Scene
from plumbob.reports.analyses.replay.body import body
from plumbob.reports.analyses.replay.capsule import capsule
from plumbob.reports.analyses.replay.pendulums import cone, pendulum
from plumbob.reports.analyses.replay.picture import Picture
from plumbob.reports.analyses.replay.runs import RECOMMENDED, shown_runs, shown_seconds
from plumbob.reports.analyses.replay.samples import COUNT, Samples, coded
from plumbob.reports.view.records import Layer, Replay

PICTURES: Mapping[str, Callable[[Case, float], Picture]] = MappingProxyType(
    {"capsule": capsule, "cone_pendulum": cone, "free_body": body, "simple_pendulum": pendulum}
)  # by the family of the system
TRUTH = Layer("exact", "exact answer", "")
Drawn = tuple[Layer, Samples]  # a motion, or a run's deviations from it, with how it is drawn
MOST = 12  # powers of ten of the largest factor that errors are drawn by
LARGE = 0.15  # of the picture: how large an audit's largest error is drawn at first, at most


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The runs that the replays of a plan's scenes show."""
    pictured = (scene for scene in plan.scenes if system_of(scene).family in PICTURES)
    return [shown.run for scene in pictured for shown in shown_runs(plan, scene)]


def replay(study: Study, scene: Scene) -> Replay | None:
    """The replay of a scene: a function of the stored study, which runs no engine; None of a system
    without a picture."""
    if system_of(scene).family not in PICTURES:
        return None
    case = case_of(scene)
    seconds = shown_seconds(scene)
    picture = PICTURES[case.system.family](case, seconds)
    times = np.linspace(0.0, seconds, COUNT)
    exact = Samples(times, picture.motion(times))
    runs: list[Drawn] = []
    lacking: list[str] = []
    plan = StudyPlan(study.profile, study.scenes, study.methods)
    missing = {  # engines that are not installed: the page says that once
        c.method
        for c in study.convergence
        if c.scene == scene.name and {m.status for m in c.measurements} == {"missing"}
    }
    for shown in shown_runs(plan, scene):
        if run := study.answer(shown.run) if shown.run in study.extras else None:
            slot = "second" if shown.words == RECOMMENDED or runs else "first"
            runs.append(deviating(picture, run, slot, shown.name, shown.words))
        elif shown.run.method not in missing:
            lacking.append(shown.name)
    return assembled(scene.name, scene.duration, picture, (TRUTH, exact), runs, lacking)


def deviating(picture: Picture, run: Trajectory, slot: str, name: str, words: str) -> Drawn:
    """A run as its deviations, with the largest over the replay and the one at its end in words."""
    every = picture.deviations(run)
    there = np.isfinite(np.sum(list(every.values()), axis=0))
    deviations = {name: values[there] for name, values in every.items()}
    last = {name: values[-1:] for name, values in deviations.items()}
    layer = Layer(slot, name, words, picture.largest(deviations), picture.largest(last))
    return layer, Samples(run.times[there], deviations)


def assembled(
    name: str,
    whole: float,
    picture: Picture,
    exact: Drawn,
    runs: Sequence[Drawn],
    lacking: Sequence[str] = (),
) -> Replay:
    """The replay of a motion of `whole` [s], as far as its samples reach, with runs as deviations
    from it."""
    seconds = float(exact[1].times[-1])
    parts = [part for _, samples in runs if (part := picture.part(samples.channels))]
    # up to where the smallest errors are as large as the picture
    powers = [10**k for k in range(MOST + 1)]
    factors = [f for f in powers if f == 1 or any(f * part < 1.0 for part in parts)]
    data = {
        "kind": picture.kind,
        "seconds": seconds,
        "box": picture.box,
        "size": next(iter(picture.sizes.values())),
        "geometry": dict(picture.geometry),
        "layers": [
            _coded(exact),
            *(_coded(run) | {"times": coded(run[1].times)} for run in runs),
        ],
    }
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return Replay(
        name,
        picture.kind,
        seconds,
        whole,
        tuple(layer for layer, _ in (exact, *runs)),
        tuple(lacking),
        tuple(factors),
        max(f for f in factors if f == 1 or f * parts[0] <= LARGE),
        text.replace("<", "\\u003c"),
    )


def _coded(drawn: Drawn) -> dict[str, Any]:
    layer, samples = drawn
    channels = {name: coded(values) for name, values in samples.channels.items()}
    return {"role": layer.slot, "count": len(samples.times), "channels": channels}
