"""The table of hard cases: digits that motions lose, and what methods lose beside them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.view.content import Table
from plumbob.reports.view.step_ranges import StepRange
from plumbob.reports.view.tables import table_or_none

ROUNDING = 2.0**-53  # relative

Case = tuple[Scene, Sequence[StepRange]]  # with the ranges of its methods


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


def table(study: Study, cases: Sequence[Case]) -> Table | None:
    """Methods on scenes, with what makes each hard and the digits that its motion loses: their
    ranges of steps, who is limited by which, the smallest error, and the digits that it loses more
    than the motion; None where no run is stored. With one scene, that scene is named nowhere."""
    rows = [
        (scene, motion, of, _beside(of.least, motion))
        for scene, ranges in cases
        for motion in [lost_by_motion(study, scene)]
        for of in ranges
        if of.least < math.inf
    ]
    return table_or_none("hard", rows=rows, several=len(cases) > 1)


def _beside(error: float, motion: float | None) -> float | None:
    """Digits that an error loses more than the motion; None where either is not known."""
    if motion is None or math.isnan(error):
        return None
    return max(digits_lost(error) - motion, 0.0)
