"""The page that compares two studies: versions, changes beyond the scatter, and pairs of scene and
method that vanished or are new."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from plumbob.engines.study.results import Study
from plumbob.reports.view.content import Table
from plumbob.reports.view.notation import number
from plumbob.reports.view.page import fill_page, write_file
from plumbob.reports.view.tables import paragraphs, table, table_or_none

Change = Mapping[str, Any]  # scene, method, what, old, new, and growth, relative to the old one
UNFOLDED_ROWS = 25  # largest number of rows of an unfolded table


def write_comparison(
    file: Path,
    studies: Sequence[tuple[str, Study]],
    moved: Mapping[str, Sequence[Change]],
    command: str,
    **growth: Any,
) -> Path:
    """Writes the page that compares two studies, whole or not at all, and returns its path.

    `studies` are the old and the new study, each with its name; `moved` holds the changes of
    verdicts, errors and presence; `command` reproduces the page; `growth` are the values that the
    template needs for errors that grew. Raises OSError if the folder cannot be written."""
    by_pair: dict[tuple[str, str], list[Change]] = {}
    for move in moved["errors"]:
        by_pair.setdefault((move["scene"], move["method"]), []).append(move)
    # the largest change of each pair, and its number of changes
    largest = [(max(moves, key=_growth), len(moves)) for moves in by_pair.values()]
    largest.sort(key=lambda pair: -_growth(pair[0]))
    measured = [move["new"] for move in moved["presence"] if move["what"] == "measured"]
    old_study, new_study = (study for _, study in studies)
    both = _pairs(old_study) & _pairs(new_study)
    lead = paragraphs(
        "compared", pairs=largest, both=both, measured=measured, **moved, **growth
    )
    old = old_study.provenance.versions
    new = new_study.provenance.versions
    versions = [(n, old.get(n, "unknown"), new.get(n, "unknown")) for n in {**old, **new}]
    rows = [(move, _percent(move["growth"]), count) for move, count in largest]
    tables = (
        _changes("Verdicts that changed", moved["verdicts"]),
        _changes("What vanished, and what is new", moved["presence"]),
        table_or_none("errors_moved", rows=rows, few=UNFOLDED_ROWS),
    )
    text = fill_page(
        "compare.html.jinja",
        lead=" ".join(lead),
        versions=table("compared_versions", rows=versions),
        tables=[written_table for written_table in tables if written_table],
        studies=studies,
        command=command,
    )
    return write_file(text, file.parent, file.name)


def _pairs(study: Study) -> set[tuple[str, str]]:
    """Returns the pairs of scene and method that a study measured."""
    return {(series.scene, series.method) for series in study.convergence}


def _changes(caption: str, changes: Sequence[Change]) -> Table | None:
    """Returns the table of changes of one kind; None if there are none."""
    return table_or_none("changes", caption=caption, rows=changes, few=UNFOLDED_ROWS)


def _growth(change: Change) -> float:
    """Returns the magnitude of a change's relative growth; infinite if the growth is None."""
    growth = change["growth"]
    return math.inf if growth is None else abs(growth)


def _percent(growth: float | None) -> str:
    """Returns a relative growth as text: a percentage, or a factor if the growth is 10 or more."""
    if growth is None or not math.isfinite(growth):
        return "–"
    if abs(growth) < 10.0:
        return f"{100.0 * growth:+.2g} %"
    return f"{number(1.0 + growth, 2)} times"
