"""The table that says how tight the tolerances of each method are."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.judge.tightness import ROUND_OFFS, Slack, Spread, slacks, spread
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Table, row

HEADS = (
    "method", "held values", "of these round-off", "allowed over actual: median", "90 %", "worst",
    "allowed over motion: median", "90 %", "worst",
)  # fmt: skip


def tables(study: Study, judged: Judgements) -> tuple[Table, ...]:
    """One table of methods whose error is predicted, and one of those whose error has a bound
    alone."""
    every = list(slacks(study, judged))
    predicted = [slack for slack in every if not slack.bound_only]
    bounded = [slack for slack in every if slack.bound_only]
    apart = f"Values within {ROUND_OFFS:g} times the round-off level are counted apart."
    parts = (
        _table(
            "How tight the tolerances are: predicted errors",
            "Over all runs that pass, and all observables that are judged: by how much measured "
            "and predicted error may differ, over the actual difference and over the motion. "
            f"{apart}",
            predicted,
        ),
        _table(
            "How tight the tolerances are: adaptive solvers and closed forms",
            "Their errors have a bound and no prediction: bound over error, and over the motion. "
            f"{apart}",
            bounded,
        ),
    )
    return tuple(table for table in parts if table is not None)


def _table(caption: str, note: str, every: Sequence[Slack]) -> Table | None:
    if not every:
        return None
    rows = []
    for method in dict.fromkeys(slack.method for slack in every):
        of_method = [slack for slack in every if slack.method == method]
        telling = [slack for slack in of_method if not slack.rounded]
        over_scale = [ratio for slack in of_method if (ratio := slack.over_scale) is not None]
        rows.append(
            row(
                Cell(method, "method"),
                Cell(str(len(of_method)), "number"),
                Cell(str(len(of_method) - len(telling)), "number"),
                *_cells(spread([slack.over_use for slack in telling])),
                *_cells(spread(over_scale)),
            )
        )
    return Table(caption, HEADS, tuple(rows), note, folded=True)


def _cells(spread: Spread | None) -> tuple[Cell, ...]:
    values = (None,) * 3 if spread is None else (spread.median, spread.most, spread.worst)
    return tuple(
        Cell("–" if value is None else notation.number(value, 2), "number") for value in values
    )
