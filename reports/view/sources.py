"""The three sources: their statements in order, and what a printed number or a judged statement
looks like."""

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
class Listed:
    """A statement of a source: the finding that computes it, empty where it can't be computed, the
    second method that this is held to, or the reason, and the test of that."""

    source: str
    place: str
    text: str
    finding: str
    beside: str
    test: str


@cache
def listed() -> tuple[Listed, ...]:
    """Every statement of the sources, in the order of their texts."""
    sources = tomllib.loads(LIST.read_text("utf-8"))
    return tuple(Listed(source, *row) for source, rows in sources.items() for row in rows)


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
