"""Results of the user's settings for a page and a terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence

from plumbob.engines.method import USER_METHOD
from plumbob.reports.advice.recommend import Choice
from plumbob.reports.advice.user_settings import UserResult
from plumbob.reports.view import notation, tables
from plumbob.reports.view.content import Table
from plumbob.reports.view.method_results import Results


def table(results: Sequence[UserResult], all_results: Results) -> Table | None:
    """Returns the table of the user's settings, with a row for each scene; None if the study has no
    user settings."""
    rows = [(result, all_results[result.scene, USER_METHOD].judged) for result in results]
    return tables.table_or_none("user_settings", rows=rows, factor=cost_factor)


def cost_factor(choice: Choice, result: UserResult) -> str:
    """Returns the cost of a choice in multiples of the cost of the user's run, as text; as a
    real-time factor if that run has no cost."""
    if not math.isfinite(result.ns_per_second):
        return notation.times_real(choice.ns_per_second) + " real time"
    return f"{notation.number(choice.ns_per_second / result.ns_per_second, 2)} of your cost"
