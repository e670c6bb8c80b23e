"""Derivatives and their errors, as lines of text and as a table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from plumbob.reports.judge.gradients import JudgedGradient
from plumbob.reports.view.content import Table
from plumbob.reports.view.notation import number
from plumbob.reports.view.tables import table as table_of
from plumbob.reports.view.terminal import aligned


def lines(judged: Sequence[JudgedGradient]) -> Iterator[str]:
    """A table, and below it why something is not there, and what is unexpected."""
    shown = table(judged)
    yield from aligned(shown)
    for of in judged:
        if of.surprise:
            yield f"UNEXPECTED {of.scene} {of.method}: {of.about}, {of.surprise}"
        elif of.known:
            yield f"known: {of.about}: {of.known}"
        elif of.why:
            yield f"{of.verdict}: {of.about}: {of.why}"
        if (sides := of.gradient.one_sided) is not None:
            below, above = (number(side, 6) for side in sides)
            yield f"  one-sided: {below} below, {above} above"


def table(judged: Sequence[JudgedGradient]) -> Table:
    """A row a derivative."""
    return table_of("gradients", records=[of.record() for of in judged])
