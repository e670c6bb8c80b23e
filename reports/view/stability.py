"""The largest steps that hold, as lines of text and as a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from plumbob.engines.study.provenance import Provenance
from plumbob.reports.judge.stability import JudgedLimit
from plumbob.reports.view.content import Table
from plumbob.reports.view.page import filled, written
from plumbob.reports.view.tables import table as table_of
from plumbob.reports.view.terminal import aligned

NAME = "stability.html"


def lines(judged: Sequence[JudgedLimit]) -> Iterator[str]:
    """A table, and below it what is unexpected."""
    shown = table(judged)
    yield from aligned([shown.heads, *([cell.text for cell in row] for row in shown.rows)])
    for limit in judged:
        if limit.surprise:
            yield f"UNEXPECTED {limit.scene} {limit.method}: {limit.surprise}"


def write_page(judged: Sequence[JudgedLimit], provenance: Provenance, folder: Path) -> Path:
    """Write `stability.html` into `folder` and return its path; raises OSError."""
    return written(render(judged, provenance), folder, NAME)


def render(judged: Sequence[JudgedLimit], provenance: Provenance) -> str:
    """The page as HTML, in one file."""
    return filled("stability.html.jinja", table=table(judged), made=provenance)


def table(judged: Sequence[JudgedLimit]) -> Table:
    """A row a limit."""
    return table_of("largest_steps", judged=judged)
