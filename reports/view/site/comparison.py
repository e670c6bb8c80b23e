"""The page of two studies compared: versions, what moved beyond scatter, vanished or is new."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from plumbob.reports.view.notation import number
from plumbob.reports.view.page import filled, written
from plumbob.reports.view.tables import paragraphs, table, table_or_none

Comparison = SimpleNamespace
"""Two studies, each with how it was made and named, and what differs between them."""
Change = Mapping[str, Any]  # scene, method, what, old, new, and growth, relative to the old one
FEW = 25  # rows of a table that is not folded


def write_comparison(of: Comparison, file: Path, command: str) -> Path:
    """Write the page, whole or not at all, and return its path; `command` is what reproduces it.
    Raises OSError where its folder cannot be written."""
    by_pair: dict[tuple[str, str], list[Change]] = {}
    for move in of.errors:
        by_pair.setdefault((move["scene"], move["method"]), []).append(move)
    most = [(max(moves, key=_size), len(moves)) for moves in by_pair.values()]
    most.sort(key=lambda pair: -_size(pair[0]))
    measured = [move for move in of.presence if move["what"] == "measured"]
    gone = sum(move["new"] == "no" for move in measured)
    lead = paragraphs("compared", pairs=most, gone=gone, come=len(measured) - gone, **vars(of))
    old, new = (source.versions for source in of.made)
    versions = [(n, old.get(n, "unknown"), new.get(n, "unknown")) for n in {**old, **new}]
    moved = [(move, _percent(move["growth"]), count) for move, count in most]
    captions = {"Verdicts that changed": of.verdicts, "What vanished, and what is new": of.presence}
    changes = [
        table_or_none("changes", caption=c, rows=rows, few=FEW) for c, rows in captions.items()
    ]
    text = filled(
        "compare.html.jinja",
        lead=" ".join(lead),
        versions=table("compared_versions", rows=versions),
        tables=[*filter(None, (*changes, table_or_none("errors_moved", rows=moved, few=FEW)))],
        names=of.names,
        made=of.made,
        command=command,
    )
    return written(text, file.parent, file.name)


def _size(change: Change) -> float:
    growth = change["growth"]
    return math.inf if growth is None else abs(growth)


def _percent(growth: float | None) -> str:
    if growth is None or not math.isfinite(growth):
        return "–"
    return f"{100.0 * growth:+.2g} %" if abs(growth) < 10.0 else f"{number(1.0 + growth, 2)} times"
