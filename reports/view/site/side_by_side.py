"""Two methods, or two engines, side by side: their errors at 1 ms on each scene that both ran."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.simulated_kinds import SIMULATED_KINDS, usual_scenes
from plumbob.reports.records.page_records import SystemRecord
from plumbob.reports.view.method_results import (
    TRUSTED_MEANINGS,
    MethodResult,
    Results,
    ShownError,
)
from plumbob.reports.view.site.matrix import engine_names, sorted_scenes
from plumbob.reports.view.site.views import PageView

CLOSED_FORM_ENGINE = "exact"  # it simulates nothing
FIRST_PAIRS = (
    ("pymunk", "mujoco"),
    ("mujoco/euler", "mujoco/rk4"),
)  # the first that has scenes
AGREEMENT = 0.01  # relative error up to which a method agrees with the exact motion
# decades that the plot shows, from the smallest error to the largest
SMALLEST_DECADE, LARGEST_DECADE = -14, 2


@dataclass(frozen=True)
class SceneErrors:
    """The errors on one scene, by the names of methods and engines. An engine has the error of its
    best method on the scene."""

    scene: str
    kind: str  # simulated kind of a usual scene; empty for any other scene
    errors: Mapping[str, ShownError]
    best: Mapping[str, str]  # best method by engine


def side_by_side(
    study: Study, all_results: Results, systems: Sequence[SystemRecord]
) -> PageView | None:
    """Returns the view of two chosen methods or engines side by side; None if no two have a scene
    in common."""
    by_scene: dict[str, list[MethodResult]] = {scene.name: [] for scene in study.scenes}
    for result in all_results.values():
        by_scene[result.scene.name].append(result)
    rows = [
        _scene_errors(by_scene[scene.name]) for scene in sorted_scenes(study.scenes, systems)
    ]
    pairs = [pair for pair in FIRST_PAIRS if any(set(pair) <= set(row.errors) for row in rows)]
    if not pairs:
        return None
    names = {name for row in rows for name in row.errors}
    engines = [name for name in engine_names(study) if name in names]
    methods = [method.name for method in study.methods if method.name in names]
    return PageView(
        names={e: [m for m in methods if m.partition("/")[0] == e] for e in engines},
        first=pairs[0],
        rows=[compared_row(row, pairs[0]) for row in rows if set(pairs[0]) <= set(row.errors)],
        summary=pair_summary(rows, pairs[0]),
        data=[
            (row.scene, row.kind, {name: _drawn(error) for name, error in row.errors.items()})
            for row in rows
            if row.errors
        ],
        decades=(SMALLEST_DECADE, LARGEST_DECADE),
        within=AGREEMENT,
    )


def _scene_errors(results: Sequence[MethodResult]) -> SceneErrors:
    """Returns the errors of methods and engines on one scene. An engine's best method is one whose
    error is as predicted or converges, if there is one, with the smallest error at 1 ms and at all
    smaller steps, but no surrogate. The closed form is left out."""
    errors = dict[str, ShownError]()
    ranks: dict[str, list[tuple[bool, float, str]]] = {}
    for result in results:
        shown, largest = result.at_reference, result.largest_at_reference
        if not shown or not largest or result.method.engine == CLOSED_FORM_ENGINE:
            continue
        errors[result.name] = shown
        if not result.method.surrogate:
            limited = result.meaning not in TRUSTED_MEANINGS
            rank = (limited, largest.error, result.name)
            ranks.setdefault(result.method.engine, []).append(rank)
    best = {engine: min(of_engine)[2] for engine, of_engine in ranks.items()}
    of_engines = {engine: errors[name] for engine, name in best.items()}
    scene = results[0].scene if results else None
    return SceneErrors(
        scene=scene.name if scene else "",
        kind=_simulated_kind(scene) if scene else "",
        errors={**of_engines, **errors},
        best=best,
    )


def _simulated_kind(scene: Scene) -> str:
    """Returns the first kind of body that a usual scene belongs to; empty if there is none."""
    kinds = (kind.name for kind in SIMULATED_KINDS if usual_scenes((scene,), kind.scenes))
    return next(kinds, "")


def _drawn(error: ShownError) -> tuple[float | None, str]:
    """Returns an error and its text; None for the error of a run that diverged."""
    return (None if math.isinf(error.error) else float(f"{error.error:.2g}")), error.text


def compared_row(row: SceneErrors, pair: tuple[str, str]) -> PageView:
    """Returns the view of one scene in the table of two methods."""
    return PageView(
        scene=row.scene,
        texts=[row.errors[name].text for name in pair],
        places=[_place(row.errors[name].error) for name in pair],
    )


def _place(error: float) -> float:
    """Returns the place [%] of an error on the plot's logarithmic axis."""
    decade = math.log10(max(error, 1e-300))
    part = (decade - SMALLEST_DECADE) / (LARGEST_DECADE - SMALLEST_DECADE)
    return round(100.0 * min(max(part, 0.0), 1.0), 1)


def pair_summary(rows: Sequence[SceneErrors], pair: tuple[str, str]) -> PageView:
    """Returns the numbers of the sentences about two methods: on how many scenes each is within
    AGREEMENT, and the largest error of each on the usual scenes of each kind of body."""
    both = [row for row in rows if set(pair) <= set(row.errors)]
    kinds = dict.fromkeys(row.kind for row in both if row.kind)
    return PageView(
        count=len(both),
        within=[sum(row.errors[name].error <= AGREEMENT for row in both) for name in pair],
        kinds=[
            (kind, [_largest_text([r for r in both if r.kind == kind], name) for name in pair])
            for kind in kinds
        ],
    )


def _largest_text(rows: Sequence[SceneErrors], name: str) -> str:
    """Returns the text of the largest error of a method on these scenes."""
    return max((row.errors[name] for row in rows), key=lambda error: error.error).text
