"""The table that says how tight the tolerances of each method are."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.reports.judge.tightness import ROUND_OFFS, Spread, Tightness
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Table, row

HEADS = (
    "method", "held values", "of these round-off", "allowed over actual: median", "90 %", "worst",
    "allowed over motion: median", "90 %", "worst",
)  # fmt: skip


def tables(every: Sequence[Tightness]) -> tuple[Table, ...]:
    """One table of methods whose error is predicted, and one of those whose error has a bound
    alone."""
    apart = f"Values within {ROUND_OFFS:g} times the round-off level are counted apart."
    parts = (
        _table(
            "How tight the tolerances are: predicted errors",
            "Over all runs that pass, and all observables that are judged: by how much measured "
            "and predicted error may differ, over the actual difference and over the motion. "
            f"{apart}",
            [tightness for tightness in every if not tightness.bound_only],
        ),
        _table(
            "How tight the tolerances are: adaptive solvers and closed forms",
            "Their errors have a bound and no prediction: bound over error, and over the motion. "
            f"{apart}",
            [tightness for tightness in every if tightness.bound_only],
        ),
    )
    return tuple(table for table in parts if table is not None)


def _table(caption: str, note: str, every: Sequence[Tightness]) -> Table | None:
    rows = tuple(
        row(
            Cell(of.method, "method"),
            Cell(str(of.held), "number"),
            Cell(str(of.rounded), "number"),
            *_cells(of.over_use),
            *_cells(of.over_scale),
        )
        for of in every
    )
    return Table(caption, HEADS, rows, note, folded=True) if rows else None


def _cells(spread: Spread | None) -> tuple[Cell, ...]:
    values = (None,) * 3 if spread is None else (spread.median, spread.most, spread.worst)
    return tuple(
        Cell("–" if value is None else notation.number(value, 2), "number") for value in values
    )
