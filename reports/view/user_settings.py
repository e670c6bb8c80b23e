"""A user's own settings as a page and a terminal show them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from plumbob.engines.method import USER_METHOD
from plumbob.reports.advice.recommend import Choice
from plumbob.reports.advice.user_settings import UserResult
from plumbob.reports.view import notation
from plumbob.reports.view.content import Table
from plumbob.reports.view.records import Verdicts
from plumbob.reports.view.tables import lines as lines_of
from plumbob.reports.view.tables import table as written
from plumbob.reports.view.tables import verdict_cell
from plumbob.reports.view.top_tables import anchor


def table(results: Sequence[UserResult], verdicts: Verdicts) -> Table | None:
    """Your settings, a row a scene; None in a study without any."""
    rows = [
        (
            result,
            _error(result),
            _finest(result),
            verdict_cell(verdicts[result.scene, USER_METHOD], anchor(result.scene)),
            [
                (choice, choice and _factor(choice, result))
                for kind in (result.at_equal_accuracy, result.better)
                for choice in (kind.here, kind.anywhere)
            ],
        )
        for result in results
    ]
    return written("user_settings", rows=rows, step=results[0].step) if rows else None


def lines(results: Sequence[UserResult]) -> list[str]:
    """The same as lines for a terminal."""
    shown = []
    for result in results:
        kinds = {"at equal accuracy": result.at_equal_accuracy, "at no greater cost": result.better}
        instead = {
            head: [
                (choice, _factor(choice, result))
                for choice in dict.fromkeys((kind.here, kind.anywhere))
                if choice
            ]
            for head, kind in kinds.items()
        }
        shown.append((result, _error(result), _finest(result), instead.items()))
    return lines_of("user_settings", results=shown)


def _factor(choice: Choice, result: UserResult) -> str:
    """The cost of a choice in those of the user's own run."""
    if not math.isfinite(result.ns_per_second):
        return notation.times_real(choice.ns_per_second) + " real time"
    return f"{notation.number(choice.ns_per_second / result.ns_per_second, 2)} of your cost"


def _error(result: UserResult) -> str:
    return notation.number(result.error) if math.isfinite(result.error) else "diverges"


def _finest(result: UserResult) -> str:
    if result.finest is None:
        return ""
    step, error = result.finest
    return f"{notation.number(error)} at {notation.short(step)} s"
