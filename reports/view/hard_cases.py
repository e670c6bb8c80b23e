"""Tables of hard cases: digits that a motion loses, and that methods lose beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from plumbob.engines.study.measurement import worst
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import EXACT
from plumbob.reports.view.content import Table
from plumbob.reports.view.records import Verdicts
from plumbob.reports.view.step_ranges import PERCENT, StepRange
from plumbob.reports.view.tables import table_or_none

ROUNDING = 2.0**-53  # relative


def digits_lost(relative: float) -> float:
    """Decimal digits of a double that an error of this relative size leaves without a meaning."""
    return math.log10(max(relative / ROUNDING, 1.0))


def lost_by_motion(study: Study, scene: Scene) -> float | None:
    """Digits that roundings of a scene's inputs cost its exact answer, of what the scene is about;
    None where no run of it is stored."""
    doubts = [
        run.errors[quantity.observable].uncertainty / quantity.scale
        for series in study.convergence
        if series.scene == scene.name
        for run in series.measurements
        if run.status == "done"
        for quantity in study.quantities(scene.name)
        if quantity.observable in run.errors and quantity.scale
    ]
    return digits_lost(max(doubts)) if doubts else None


def of_system(study: Study, scenes: Sequence[Scene], verdicts: Verdicts) -> Table | None:
    """The hard scenes of a system: what is hard, digits that the motion loses, and the smallest
    error of a full model there with the digits that it loses beside them."""
    rows = []
    for scene in (scene for scene in scenes if scene.hard):
        errors = [
            (judged.smallest, method.name)
            for method in study.methods
            if not method.surrogate
            and method.scheme.integrator != EXACT
            and (judged := verdicts.get((scene.name, method.name))) is not None
            and judged.smallest is not None
        ]
        error, name = min(errors, default=(float("nan"), "none"))
        motion = lost_by_motion(study, scene)
        rows.append((scene, motion, error, name, _beside(error, motion)))
    return table_or_none("hard", rows=rows)


def of_scene(study: Study, scene: Scene, ranges: Sequence[StepRange]) -> Table | None:
    """Methods on one scene: the largest step that was run with an error of 1 % or less, the largest
    that is stable, who is limited by which, the smallest error, and the digits that it loses more
    than the motion."""
    motion, rows = lost_by_motion(study, scene), []
    by_method = {of.method: of for of in ranges}
    controls = {method.name: method.control for method in study.methods}
    for series in study.convergence:
        errors = {
            run.step: worst(run, study.quantities(scene.name))[1]
            for run in series.measurements
            if series.scene == scene.name and run.status == "done"
        }
        if errors:
            least = min(errors.values())
            within = max((s for s, error in errors.items() if error <= PERCENT), default=None)
            control = controls[series.method]
            steps = by_method.get(series.method)
            rows.append((series.method, least, _beside(least, motion), within, control, steps))
    return table_or_none("hard_digits", rows=rows, motion=motion)


def _beside(error: float, motion: float | None) -> float | None:
    """Digits that an error loses more than the motion; None where either is not known."""
    if motion is None or math.isnan(error):
        return None
    return max(digits_lost(error) - motion, 0.0)
