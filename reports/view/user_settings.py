"""A user's own settings as a page and a terminal show them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from plumbob.engines.method import USER_METHOD
from plumbob.reports.advice.recommend import Choice
from plumbob.reports.advice.user_settings import UserResult
from plumbob.reports.view import notation, tables
from plumbob.reports.view.content import Table
from plumbob.reports.view.method_results import Results


def table(results: Sequence[UserResult], every: Results) -> Table | None:
    """Your settings, a row a scene; None in a study without any."""
    rows = [(of, every[of.scene, USER_METHOD].judged) for of in results]
    return tables.table_or_none("user_settings", rows=rows, factor=cost_factor)


def cost_factor(choice: Choice, result: UserResult) -> str:
    """The cost of a choice in those of the user's own run."""
    if not math.isfinite(result.ns_per_second):
        return notation.times_real(choice.ns_per_second) + " real time"
    return f"{notation.number(choice.ns_per_second / result.ns_per_second, 2)} of your cost"
