"""The largest stable steps, or the results of long runs, as a table and as a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from plumbob.engines.study.provenance import Provenance
from plumbob.reports.judge.long_runs import JudgedLongRun
from plumbob.reports.judge.stability import JudgedLimit
from plumbob.reports.view.content import Table
from plumbob.reports.view.page import fill_page, write_file
from plumbob.reports.view.tables import table as table_of

NAME = "stability.html"
Judged = Sequence[JudgedLimit | JudgedLongRun]


def write_stability_page(judged: Judged, provenance: Provenance, folder: Path) -> Path:
    """Writes `stability.html` into `folder` and returns its path; raises OSError if the folder
    cannot be written."""
    page = fill_page(
        "stability.html.jinja",
        table=table(judged),
        long=_has_long_runs(judged),
        made=provenance,
    )
    return write_file(page, folder, NAME)


def table(judged: Judged) -> Table:
    """Returns the table with a row for each largest step, or for each long run."""
    if _has_long_runs(judged):
        return table_of("long_runs", judged=judged)
    limits = [limit.record() for limit in judged]
    return table_of("largest_steps", limits=limits, folded=False)


def _has_long_runs(judged: Judged) -> bool:
    """Returns whether the results are long runs, and not largest steps."""
    return any(isinstance(result, JudgedLongRun) for result in judged)
