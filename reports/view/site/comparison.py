"""The page that compares two studies: versions, changes beyond the scatter, and pairs of scene and
method that vanished or are new."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from plumbob.engines.study.results import Study
from plumbob.reports.view.notation import number
from plumbob.reports.view.page import filled, written
from plumbob.reports.view.tables import paragraphs, table, table_or_none

Change = Mapping[str, Any]  # scene, method, what, old, new, and growth, relative to the old one
FEW = 25  # rows of a table that is not folded


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
    most = [(max(moves, key=_size), len(moves)) for moves in by_pair.values()]
    most.sort(key=lambda pair: -_size(pair[0]))
    measured = [move["new"] for move in moved["presence"] if move["what"] == "measured"]
    both = set.intersection(*({(c.scene, c.method) for c in s.convergence} for _, s in studies))
    lead = paragraphs("compared", pairs=most, both=both, measured=measured, **moved, **growth)
    old, new = (study.provenance.versions for _, study in studies)
    versions = [(n, old.get(n, "unknown"), new.get(n, "unknown")) for n in {**old, **new}]
    changes = (
        table_or_none("changes", caption=caption, rows=moved[kind], few=FEW)
        for caption, kind in (
            ("Verdicts that changed", "verdicts"),
            ("What vanished, and what is new", "presence"),
        )
    )
    rows = [(move, _percent(move["growth"]), count) for move, count in most]
    text = filled(
        "compare.html.jinja",
        lead=" ".join(lead),
        versions=table("compared_versions", rows=versions),
        tables=[*filter(None, (*changes, table_or_none("errors_moved", rows=rows, few=FEW)))],
        studies=studies,
        command=command,
    )
    return written(text, file.parent, file.name)


def _size(change: Change) -> float:
    growth = change["growth"]
    return math.inf if growth is None else abs(growth)


def _percent(growth: float | None) -> str:
    if growth is None or not math.isfinite(growth):
        return "–"
    return (
        f"{100.0 * growth:+.2g} %" if abs(growth) < 10.0 else f"{number(1.0 + growth, 2)} times"
    )
