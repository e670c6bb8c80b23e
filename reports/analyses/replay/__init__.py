"""Replays of scenes on the page: the exact motion and two runs over it, from the stored study."""

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
from plumbob.reports.analyses.replay.body import body_picture
from plumbob.reports.analyses.replay.capsule import capsule_picture
from plumbob.reports.analyses.replay.pendulums import cone_picture, pendulum_picture
from plumbob.reports.analyses.replay.picture import Picture
from plumbob.reports.analyses.replay.runs import RECOMMENDED_SETTINGS, shown_runs, shown_seconds
from plumbob.reports.analyses.replay.samples import REPLAY_SAMPLES, Samples, encode_samples
from plumbob.reports.records.page_records import Layer, Replay

# function that makes the picture, by the family of the system
PICTURES: Mapping[str, Callable[[Case, float], Picture]] = MappingProxyType(
    {
        "capsule": capsule_picture,
        "cone_pendulum": cone_picture,
        "free_body": body_picture,
        "simple_pendulum": pendulum_picture,
    }
)
TRUTH = Layer("exact", "exact answer", "")
Drawn = tuple[Layer, Samples]  # layer, and samples of a motion or of a run's deviations from it
MAX_FACTOR_EXPONENT = 12  # exponent of ten of the largest magnification of errors
INITIAL_ERROR_SIZE = 0.15  # initial size of an audit's largest error, relative to the picture


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Returns the runs that the replays of a plan's scenes show."""
    pictured = (scene for scene in plan.scenes if system_of(scene).family in PICTURES)
    return [shown.run for scene in pictured for shown in shown_runs(plan, scene)]


def replay(study: Study, scene: Scene) -> Replay | None:
    """Returns the replay of a scene from the stored study; None if its system has no picture."""
    if system_of(scene).family not in PICTURES:
        return None
    case = case_of(scene)
    seconds = shown_seconds(scene)
    picture = PICTURES[case.system.family](case, seconds)
    times = np.linspace(0.0, seconds, REPLAY_SAMPLES)
    exact = Samples(times, picture.motion(times))
    runs: list[Drawn] = []
    lacking: list[str] = []
    plan = StudyPlan(study.profile, study.scenes, study.methods)
    missing = _missing_methods(study, scene.name)
    for shown in shown_runs(plan, scene):
        run = study.answer(shown.run) if shown.run in study.extras else None
        if run:
            slot = "second" if shown.words == RECOMMENDED_SETTINGS or runs else "first"
            runs.append(run_deviations(picture, run, slot, shown.name, shown.words))
        elif shown.run.method not in missing:
            lacking.append(shown.name)
    return assemble_replay(scene.name, scene.duration, picture, (TRUTH, exact), runs, lacking)


def _missing_methods(study: Study, scene: str) -> set[str]:
    """Returns the methods whose engines are not installed; the page says so elsewhere."""
    missing = set[str]()
    for series in study.convergence:
        statuses = {run.status for run in series.measurements}
        if series.scene == scene and statuses == {"missing"}:
            missing.add(series.method)
    return missing


def run_deviations(
    picture: Picture, run: Trajectory, slot: str, name: str, words: str
) -> Drawn:
    """Returns a run as its deviations from the exact motion, at the finite samples. Its layer
    states the largest deviation of the replay and the deviation at the end, as text."""
    channels = picture.deviations(run)
    finite = np.isfinite(np.sum(list(channels.values()), axis=0))
    deviations = {name: values[finite] for name, values in channels.items()}
    last = {name: values[-1:] for name, values in deviations.items()}
    layer = Layer(slot, name, words, picture.largest(deviations), picture.largest(last))
    return layer, Samples(run.times[finite], deviations)


def assemble_replay(
    name: str,
    whole: float,
    picture: Picture,
    exact: Drawn,
    runs: Sequence[Drawn],
    lacking: Sequence[str] = (),
) -> Replay:
    """Returns the replay of a motion, with runs as deviations from it.

    `name` is the scene, `whole` its duration [s], `exact` the motion, which may end earlier, and
    `lacking` the names of the runs that did not reach their end."""
    seconds = float(exact[1].times[-1])
    sizes = [picture.part(samples.channels) for _, samples in runs]
    sizes = [size for size in sizes if size]
    # The largest magnification keeps the errors of at least one run within the picture.
    powers = [10**k for k in range(MAX_FACTOR_EXPONENT + 1)]
    factors = [f for f in powers if f == 1 or any(f * size < 1.0 for size in sizes)]
    data = {
        "kind": picture.kind,
        "seconds": seconds,
        "box": picture.box,
        "size": next(iter(picture.sizes.values())),
        "geometry": dict(picture.geometry),
        "layers": [
            _coded(exact),
            *(_coded(run) | {"times": encode_samples(run[1].times)} for run in runs),
        ],
    }
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return Replay(
        scene=name,
        kind=picture.kind,
        seconds=seconds,
        whole=whole,
        layers=tuple(layer for layer, _ in (exact, *runs)),
        lacking=tuple(lacking),
        factors=tuple(factors),
        magnified=max(f for f in factors if f == 1 or f * sizes[0] <= INITIAL_ERROR_SIZE),
        data=text.replace("<", "\\u003c"),
    )


def _coded(drawn: Drawn) -> dict[str, Any]:
    """Returns a layer and its samples for JSON."""
    layer, samples = drawn
    channels = {name: encode_samples(values) for name, values in samples.channels.items()}
    return {"role": layer.slot, "count": len(samples.times), "channels": channels}
