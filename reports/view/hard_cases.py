"""The table of hard cases: digits that motions lose, and what methods lose beside them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from plumbob.reports.view.content import Table
from plumbob.reports.view.method_results import MethodResult
from plumbob.reports.view.tables import table_or_none

ROUNDING = 2.0**-53  # relative


def digits_lost(relative: float) -> float:
    """Decimal digits of a double that an error of this relative size leaves without a meaning: at
    most all that it has."""
    return math.log10(max(min(relative, 1.0) / ROUNDING, 1.0))


def lost_by_motion(results: Sequence[MethodResult]) -> float | None:
    """Digits that roundings of a scene's inputs cost its exact answer, of what the scene is about;
    None where no run of it is stored."""
    doubts = [
        run.errors[quantity.observable].uncertainty / quantity.scale
        for of in results
        for run in of.done
        for quantity in of.quantities
        if quantity.observable in run.errors and quantity.scale
    ]
    return digits_lost(max(doubts)) if doubts else None


def table(scenes: Sequence[Sequence[MethodResult]]) -> Table | None:
    """Methods on scenes, with what makes each hard and the digits that its motion loses: their
    largest steps, who is limited by which, the smallest error, and the digits that it loses more
    than the motion; None where no run is stored. With one scene, that scene is named nowhere."""
    rows = []
    for results in scenes:
        motion = lost_by_motion(results)
        for of in results:
            if (error := min(of.errors.values(), default=math.inf)) < math.inf:
                more = None if motion is None else max(digits_lost(error) - motion, 0.0)
                rows.append((of.scene, motion, of, error, more))
    return table_or_none("hard", rows=rows, several=len(scenes) > 1)
