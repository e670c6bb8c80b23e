"""The three sources by name, and what a printed number or a judged statement looks like."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

from plumbob.reports.view.content import Statement, Table, row
from plumbob.reports.view.overview import SOURCES

SUDAKOV, CHERNOUSKO, NOTEBOOK = SOURCES


def as_printed(
    source: str, place: str, text: str, printed: str, ours: float, unit: str
) -> Statement:
    """A number that a source prints, such as "35.809", beside ours: it holds where ours rounds
    to it, to half a unit of its last digit."""
    last = Decimal(1).scaleb(int(Decimal(printed).as_tuple().exponent))
    holds = abs(Decimal(float(ours)) - Decimal(printed)) <= last / 2
    digits = len(printed.partition(".")[2]) + 3
    return Statement(
        source,
        place,
        text,
        f"{printed} {unit}",
        f"{ours:.{digits}f} {unit}",
        "holds" if holds else "corrected",
    )


def judged(statement: Statement) -> str:
    """The verdict in a word, with the reason where there is one."""
    return f"{statement.verdict}: {statement.why}" if statement.why else statement.verdict


def stated(statements: Sequence[Statement]) -> Table:
    """The statements of one finding, as a table of its own."""
    rows = (row(s.place, s.text, s.said, s.ours, judged(s)) for s in statements)
    heads = ("place", "statement", "the source's value", "ours", "verdict")
    return Table("Statement by statement", heads, tuple(rows))
