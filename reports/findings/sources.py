"""The three sources by name, and what a printed number or a judged statement looks like."""

from __future__ import annotations

from decimal import Decimal

from plumbob.reports.view.content import Statement

SUDAKOV, CHERNOUSKO, NOTEBOOK = "Sudakov 2015", "Chernousko 2020", "Pêndulo Simples"


def as_printed(source: str, place: str, text: str, said: str, ours: float, unit: str) -> Statement:
    """A number that a source prints, such as "35.809", beside ours: it holds where ours rounds
    to it, to half a unit of its last digit."""
    last = Decimal(1).scaleb(int(Decimal(said).as_tuple().exponent))
    holds = abs(Decimal(float(ours)) - Decimal(said)) <= last / 2
    digits = len(said.partition(".")[2]) + 3
    return Statement(source, place, text, f"{said} {unit}", f"{ours:.{digits}f} {unit}",
                     "holds" if holds else "corrected")  # fmt: skip


def judged(statement: Statement) -> str:
    """The verdict in a word, with the reason where there is one."""
    return f"{statement.verdict}: {statement.why}" if statement.why else statement.verdict
