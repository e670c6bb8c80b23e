"""The largest stable steps, or the results of long runs, as a table and as a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from plumbob.engines.study.provenance import Provenance
from plumbob.reports.judge.long_runs import JudgedLongRun
from plumbob.reports.judge.stability import JudgedLimit
from plumbob.reports.view.content import Table
from plumbob.reports.view.page import filled, written
from plumbob.reports.view.tables import table as table_of

NAME = "stability.html"
Judged = Sequence[JudgedLimit | JudgedLongRun]


def write_page(judged: Judged, provenance: Provenance, folder: Path) -> Path:
    """Writes `stability.html` into `folder` and returns its path; raises OSError if the folder
    cannot be written."""
    long = _long(judged)
    shown = table(judged)
    page = filled("stability.html.jinja", table=shown, long=long, made=provenance)
    return written(page, folder, NAME)


def table(judged: Judged) -> Table:
    """Returns the table with a row for each largest step, or for each long run."""
    if _long(judged):
        return table_of("long_runs", judged=judged)
    return table_of("largest_steps", limits=[of.record() for of in judged], folded=False)


def _long(judged: Judged) -> bool:
    return any(isinstance(one, JudgedLongRun) for one in judged)
