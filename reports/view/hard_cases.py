"""The table of hard cases: digits lost by the motion itself, and further digits lost by methods."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence

from plumbob.reports.view.content import Table
from plumbob.reports.view.method_results import MethodResult
from plumbob.reports.view.tables import table_or_none


def digits_lost(relative: float) -> float:
    """Returns the number of decimal digits of a double that a relative error makes meaningless; at
    most all of its digits (16)."""
    rounding = sys.float_info.epsilon / 2.0  # largest relative error of one rounding
    return math.log10(max(min(relative, 1.0) / rounding, 1.0))


def lost_by_motion(results: Sequence[MethodResult]) -> float | None:
    """Returns the decimal digits that the exact answer of a scene loses to rounding of the scene's
    inputs, the most over its quantities of interest; None if no run is stored."""
    uncertainties = list[float]()  # relative
    for result in results:
        for run in result.done:
            uncertainties += [
                run.errors[quantity.observable].uncertainty / quantity.scale
                for quantity in result.quantities
                if quantity.observable in run.errors and quantity.scale
            ]
    return digits_lost(max(uncertainties)) if uncertainties else None


def hard_case_table(scenes: Sequence[Sequence[MethodResult]]) -> Table | None:
    """Returns the table of hard cases, with a row for each scene and method; None if no run is
    stored.

    A row has the reason that the scene is hard, the digits that its motion loses, the largest steps
    of the method and what limits them, its smallest error, and the digits that the method loses
    beyond the motion. If there is only one scene, the table does not name it."""
    rows = []
    for results in scenes:
        by_motion = lost_by_motion(results)
        for result in results:
            smallest_error = min(result.errors.values(), default=math.inf)
            if math.isinf(smallest_error):
                continue
            by_method = None
            if by_motion is not None:
                by_method = max(digits_lost(smallest_error) - by_motion, 0.0)
            rows.append((result.scene, by_motion, result, smallest_error, by_method))
    return table_or_none("hard", rows=rows, several=len(scenes) > 1)
