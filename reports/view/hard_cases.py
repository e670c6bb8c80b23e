"""The table of hard cases: digits that motions lose, and what methods lose beside them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from plumbob.engines.study.measurement import worst
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.view.content import Table
from plumbob.reports.view.step_ranges import PERCENT, step_ranges
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


def table(study: Study, scenes: Sequence[Scene]) -> Table | None:
    """Methods on scenes, with what makes each hard and the digits that its motion loses: the
    largest step that was run with an error of 1 % or less, the largest that is stable, who is
    limited by which, the smallest error, and the digits that it loses more than the motion; None
    where no run is stored. With one scene, that scene is named nowhere."""
    rows = [row for scene in scenes for row in _rows(study, scene)]
    return table_or_none("hard", rows=rows, several=len(scenes) > 1)


def _rows(study: Study, scene: Scene) -> Iterator[tuple[object, ...]]:
    motion = lost_by_motion(study, scene)
    by_method = {of.method: of for of in step_ranges(study, scene)}
    controls = {method.name: method.control for method in study.methods}
    for series in study.convergence:
        errors = {
            run.step: worst(run, study.quantities(scene.name))[1]
            for run in series.measurements
            if series.scene == scene.name and run.status == "done"
        }
        if errors:
            least, name = min(errors.values()), series.method
            within = max((s for s, error in errors.items() if error <= PERCENT), default=None)
            more = _beside(least, motion)
            yield scene, motion, name, within, controls[name], by_method.get(name), least, more


def _beside(error: float, motion: float | None) -> float | None:
    """Digits that an error loses more than the motion; None where either is not known."""
    if motion is None or math.isnan(error):
        return None
    return max(digits_lost(error) - motion, 0.0)
