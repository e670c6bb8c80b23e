"""The three sources and their statements, and the judgement of a printed number."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from pathlib import Path

from plumbob.reports.view.content import Statement

LIST = Path(__file__).parents[1] / "templates" / "statements.toml"

SOURCES = ("Sudakov 2015", "Chernousko 2020", "Pêndulo Simples")
SUDAKOV, CHERNOUSKO, NOTEBOOK = SOURCES


@dataclass(frozen=True)
class ListedStatement:
    """A statement of a source, and how the product computes it."""

    source: str
    place: str  # equation, figure or section of the source
    text: str
    finding: str  # name of the finding that computes it; empty if it cannot be computed
    beside: str  # independent method that confirms it, or the reason that it cannot be computed
    test: str  # test of the independent method


@cache
def listed_statements() -> tuple[ListedStatement, ...]:
    """Returns all statements of the sources, in the order of the sources' texts."""
    rows_by_source = tomllib.loads(LIST.read_text("utf-8"))
    statements = list[ListedStatement]()
    for source, rows in rows_by_source.items():
        statements += [ListedStatement(source, *row) for row in rows]
    return tuple(statements)


def as_printed(
    source: str, place: str, text: str, printed: str, ours: float, unit: str
) -> Statement:
    """Returns the statement that compares a printed number, such as "35.809", with the computed
    number `ours`. The statement holds if they differ by at most half a unit of the last printed
    digit; otherwise it is corrected."""
    last_digit = Decimal(1).scaleb(int(Decimal(printed).as_tuple().exponent))
    holds = abs(Decimal(float(ours)) - Decimal(printed)) <= last_digit / 2
    digits = len(printed.partition(".")[2]) + 3
    return Statement(
        source=source,
        place=place,
        text=text,
        said=f"{printed} {unit}",
        ours=f"{ours:.{digits}f} {unit}",
        verdict="holds" if holds else "corrected",
    )
