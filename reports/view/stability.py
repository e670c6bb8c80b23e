"""The largest steps that hold, or the times of long runs, as lines of text and as a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from plumbob.engines.study.provenance import Provenance
from plumbob.reports.judge.long_runs import JudgedLongRun
from plumbob.reports.judge.stability import JudgedLimit
from plumbob.reports.view.content import Table
from plumbob.reports.view.page import filled, written
from plumbob.reports.view.tables import table as table_of
from plumbob.reports.view.terminal import aligned

NAME = "stability.html"
Judged = Sequence[JudgedLimit | JudgedLongRun]


def lines(judged: Judged) -> Iterator[str]:
    """A table, and below it what is unexpected."""
    shown = table(judged)
    yield from aligned(shown)
    for one in judged:
        if one.surprise:
            record = one.record()
            yield f"UNEXPECTED {record['scene']} {record['method']}: {one.surprise}"


def write_page(judged: Judged, provenance: Provenance, folder: Path) -> Path:
    """Write `stability.html` into `folder` and return its path; raises OSError."""
    return written(render(judged, provenance), folder, NAME)


def render(judged: Judged, provenance: Provenance) -> str:
    """The page as HTML, in one file."""
    return filled("stability.html.jinja", table=table(judged), long=_long(judged), made=provenance)


def table(judged: Judged) -> Table:
    """A row a limit, or a long run."""
    if _long(judged):
        return table_of("long_runs", judged=judged)
    return table_of("largest_steps", limits=[of.record() for of in judged], folded=False)


def _long(judged: Judged) -> bool:
    return any(isinstance(one, JudgedLongRun) for one in judged)
