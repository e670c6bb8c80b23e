"""The page of two studies compared: versions, what moved beyond scatter, vanished or is new."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from plumbob.reports.view.content import Table
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
    pairs = [move for move in of.presence if move["what"] == "measured"]
    lead = paragraphs(
        "compared",
        pairs=_by_pair(of.errors),
        gone=sum(move["new"] == "no" for move in pairs),
        come=sum(move["old"] == "no" for move in pairs),
        **vars(of),
    )
    old, new = (source.versions for source in of.made)
    names = dict.fromkeys((*old, *new))
    tables = (
        _changes("Verdicts that changed", of.verdicts),
        _changes("What vanished, and what is new", of.presence),
        _errors(of.errors),
    )
    text = filled(
        "compare.html.jinja",
        lead=" ".join(lead),
        versions=table(
            "compared_versions",
            rows=[(n, old.get(n, "unknown"), new.get(n, "unknown")) for n in names],
        ),
        tables=[*filter(None, tables)],
        names=of.names,
        made=of.made,
        command=command,
    )
    return written(text, file.parent, file.name)


def _by_pair(moves: Sequence[Change]) -> Mapping[tuple[str, str], list[Change]]:
    """Changes by scene and method."""
    by_pair: dict[tuple[str, str], list[Change]] = {}
    for move in moves:
        by_pair.setdefault((move["scene"], move["method"]), []).append(move)
    return by_pair


def _changes(caption: str, changes: Sequence[Change]) -> Table | None:
    """Changes as they are; None without any."""
    return table_or_none("changes", caption=caption, rows=changes, few=FEW)


def _errors(moves: Sequence[Change]) -> Table | None:
    """Of each pair whose errors moved, the one that moved most; None where none did."""
    most = [(max(of, key=_size), len(of)) for of in _by_pair(moves).values()]
    most.sort(key=lambda pair: -_size(pair[0]))
    rows = [(move, _percent(move["growth"]), count) for move, count in most]
    return table_or_none("errors_moved", rows=rows, few=FEW)


def _size(change: Change) -> float:
    growth = change["growth"]
    return math.inf if growth is None else abs(growth)


def _percent(growth: float | None) -> str:
    if growth is None or not math.isfinite(growth):
        return "–"
    return f"{100.0 * growth:+.2g} %" if abs(growth) < 10.0 else f"{number(1.0 + growth, 2)} times"
