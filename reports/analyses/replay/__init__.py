"""Replays of scenes on the page: the exact motion and two runs over it, from the stored study."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.drawn_mechanism import SceneDrawing
from plumbob.engines.method import meant
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.extra_runs import DrawingRequest, StudyPlan
from plumbob.engines.study.request import Request
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of, system_of
from plumbob.models.scene import Case, Scene
from plumbob.reports.analyses.replay.coordinates import (
    coordinate_changes,
    exact_coordinates,
    interpolated,
    with_prescribed_joints,
)
from plumbob.reports.analyses.replay.picture import Picture
from plumbob.reports.analyses.replay.runs import RECOMMENDED_SETTINGS, shown_runs, shown_seconds
from plumbob.reports.analyses.replay.samples import REPLAY_SAMPLES, RESOLUTION, encode_samples
from plumbob.reports.records import notation
from plumbob.reports.records.page_records import Layer, Replay

TRUTH = Layer("exact", "exact answer", "")
TRAIL, THUMBNAIL_TRAIL = 12.0, 4.0  # ratio of the duration to the duration of the trail
MAX_FACTOR_EXPONENT = 12  # exponent of ten of the largest magnification of errors
INITIAL_ERROR_SIZE = 0.15  # initial size of an audit's largest error, relative to the picture
# A thumbnail shows the motion until a corner has moved by so many sizes of the picture, in so many
# samples, rounded to so many parts of a coordinate's range.
THUMBNAIL_SIZES, THUMBNAIL_SAMPLES, THUMBNAIL_RESOLUTION = 8.0, 41, 2**12 - 1


@dataclass(frozen=True)
class DrawnRun:
    """A run in a replay: its layer, and at times [s], shape (n,), its coordinates less the exact
    ones, shape (n, k), and its error [m], the largest displacement of any corner of a body."""

    layer: Layer
    times: Array
    changes: Array
    errors: Array


def requests(plan: StudyPlan) -> Sequence[Request[Any]]:
    """Returns the requests for the drawings and the runs of the replays of a plan's scenes."""
    wanted = list[Request[Any]]()
    for scene in plan.scenes:
        drawing = _drawing_request(scene)
        if drawing:
            wanted += [drawing, *(shown.run for shown in shown_runs(plan, scene))]
    return wanted


def _drawing_request(scene: Scene) -> DrawingRequest | None:
    """Returns the request for the drawing of a scene; None if the scene has no model file or no
    method of the engine that compiles it."""
    if not system_of(scene).model_module:
        return None
    known = (method.name for method in find_methods("mujoco/*") if meant(method, scene))
    method = next(known, None)
    return DrawingRequest(scene.name, method, shown_seconds(scene)) if method else None


def replay(study: Study, scene: Scene) -> Replay | None:
    """Returns the replay of a scene from the stored study; None if its mechanism has no shape that
    moves, or if the study has no drawing of it."""
    request = _drawing_request(scene)
    drawing = study.extras.get(request) if request else None
    if drawing is None:
        return None
    seconds = shown_seconds(scene)
    case = case_of(scene).lasting(seconds)
    drawing = with_prescribed_joints(case, drawing)
    times = np.linspace(0.0, seconds, REPLAY_SAMPLES)
    picture = Picture(drawing.mechanism, exact_coordinates(case, drawing, times))
    if not picture.moving:
        return None
    runs: list[DrawnRun] = []
    lacking: list[str] = []
    plan = StudyPlan(study.profile, study.scenes, study.methods)
    missing = _missing_methods(study, scene.name)
    for shown in shown_runs(plan, scene):
        run = study.answer(shown.run) if shown.run in study.extras else None
        if run:
            slot = "second" if shown.words == RECOMMENDED_SETTINGS or runs else "first"
            layer = Layer(slot, shown.name, shown.words)
            runs.append(_drawn_run(case, drawing, picture, run, layer))
        elif shown.run.method not in missing:
            lacking.append(shown.name)
    return assemble_replay(scene.name, scene.duration, picture, times, runs, TRUTH, lacking)


def _missing_methods(study: Study, scene: str) -> set[str]:
    """Returns the methods whose engines are not installed; the page says so elsewhere."""
    missing = set[str]()
    for series in study.convergence:
        statuses = {run.status for run in series.measurements}
        if series.scene == scene and statuses == {"missing"}:
            missing.add(series.method)
    return missing


def _drawn_run(
    case: Case, drawing: SceneDrawing, picture: Picture, run: Trajectory, layer: Layer
) -> DrawnRun:
    """Returns a run of a case for its replay, at the samples at which its observables are
    finite."""
    finite = np.isfinite(np.sum(list(run.observables.values()), axis=0))
    times = run.times[finite]
    exact = case.reference.observe(times)
    errors = {
        name: values[finite] - exact[name]
        for name, values in run.observables.items()
        if name in exact
    }
    coordinates = exact_coordinates(case, drawing, times)
    changes = coordinate_changes(case, drawing.mechanism, coordinates, errors)
    return drawn_run(layer, times, changes, picture.errors(coordinates, changes))


def drawn_run(layer: Layer, times: Array, changes: Array, errors: Array) -> DrawnRun:
    """Returns a run for a replay. Its layer states the largest error and the error at the end, as
    text."""
    largest, end = map(notation.metres, (float(errors.max()), float(errors[-1])))
    stated = Layer(layer.slot, layer.name, layer.words, largest, end)
    return DrawnRun(stated, times, changes, errors)


def assemble_replay(
    name: str,
    whole: float,
    picture: Picture,
    times: Array,
    runs: Sequence[DrawnRun],
    exact: Layer,
    lacking: Sequence[str] = (),
) -> Replay:
    """Returns the replay of a motion, with runs over it.

    `name` is the scene, `whole` its duration [s]; the motion has the coordinates of the picture at
    `times` [s], which may end earlier; `exact` is its layer, and `lacking` are the names of the
    runs that did not reach their end."""
    seconds = float(times[-1])
    sizes = [float(run.errors.max()) / picture.size for run in runs if run.errors.any()]
    # The largest magnification keeps the errors of at least one run within the picture.
    powers = [10**k for k in range(MAX_FACTOR_EXPONENT + 1)]
    factors = [f for f in powers if f == 1 or any(f * size < 1.0 for size in sizes)]
    moved = np.zeros_like(picture.coordinates) + np.ptp(picture.coordinates, axis=0)
    if runs:
        moved = interpolated(runs[0].times, runs[0].changes, times)
    drawn = {"seconds": seconds, **picture.geometry(), "mark": picture.mark(moved)}
    layers = [
        _coded(exact.slot, picture.coordinates),
        *(
            {
                **_coded(run.layer.slot, run.changes),
                "times": encode_samples(run.times),
                "error": encode_samples(run.errors),
            }
            for run in runs
        ),
    ]
    lively = seconds * picture.lively_part(THUMBNAIL_SIZES)
    few = np.linspace(0.0, lively, THUMBNAIL_SAMPLES)
    small = interpolated(times, picture.coordinates, few)
    thumbnail = [_coded(exact.slot, small, THUMBNAIL_RESOLUTION)]
    return Replay(
        scene=name,
        kind=picture.view[0],
        seconds=seconds,
        whole=whole,
        layers=(exact, *(run.layer for run in runs)),
        lacking=tuple(lacking),
        factors=tuple(factors),
        magnified=max(f for f in factors if f == 1 or f * sizes[0] <= INITIAL_ERROR_SIZE),
        data=_for_script({**drawn, "trail": seconds / TRAIL, "layers": layers}),
        thumbnail=_for_script(
            {**drawn, "seconds": lively, "trail": lively / THUMBNAIL_TRAIL, "layers": thumbnail}
        ),
    )


def _for_script(data: Mapping[str, Any]) -> str:
    """Returns data as JSON without any text that an HTML parser takes for a tag."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"), default=np.ndarray.tolist)
    return text.replace("<", "\\u003c")


def _coded(slot: str, coordinates: Array, resolution: int = RESOLUTION) -> dict[str, Any]:
    """Returns coordinates in the style of a slot, shape (n, k), for JSON."""
    channels = [encode_samples(values, resolution) for values in coordinates.T]
    return {"role": slot, "count": len(coordinates), "channels": channels}
