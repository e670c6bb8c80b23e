"""The three sources: their statements in order, and what a printed number or a judged statement
looks like."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from types import MappingProxyType

from plumbob.reports.view.content import Statement

# The sources in the order of their table, each with its places in the order of its text.
PLACES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "Sudakov 2015": (
            "introduction",
            "terms",
            "characteristics",
            "(1)",
            "(2)–(6)",
            "(4)",
            "(6)",
            "(6), (7)",
            "(7), (9)",
            "(8)",
            "(2)–(6), (9)",
            "(9), (15), (16), Fig. 3",
            "(10)–(13)",
            "(15), (16)",
            "(16)",
            "numerical experiment",
            "Fig. 2",
            "Fig. 2 e",
            "Fig. 3",
            "Fig. 3 b",
            "Fig. 3 c",
            "Fig. 3 e",
            "conclusion",
        ),
        "Chernousko 2020": (
            "assumptions",
            "(1)",
            "modes",
            "(2)–(4), (23)",
            "slow motions",
            "residual motions",
            "(5)–(7)",
            "(7)",
            "(3), (9)",
            "(8)–(12)",
            "(15)",
            "(17), (20), Fig. 2",
            "(18)",
            "(19), (20)",
            "(21)",
            "(22), Fig. 2",
            "(11)–(22)",
            "after (22)",
            "(24), (25)",
            "(28)",
            "(30)",
            "(31), Fig. 3",
            "(31), (32)",
            "(32)",
            "after (32)",
            "controllability",
            "controllability, 1 and 3",
            "controllability, 3",
            "conclusion",
        ),
        "Pêndulo Simples": (
            "acceleration",
            "equation of motion",
            "T",
            "linear equation",
            "F(t)",
            "parameters",
            "X₁, X₂",
            "integrator",
            *(f"case {number}" for number in range(1, 8)),
        ),
    }
)
SOURCES = tuple(PLACES)
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
