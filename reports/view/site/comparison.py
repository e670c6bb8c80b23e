"""The page of two studies compared: versions, what moved beyond scatter, vanished or is new."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from plumbob.reports.view.content import Figure, Table, Trace
from plumbob.reports.view.notation import number, plural
from plumbob.reports.view.page import filled, written
from plumbob.reports.view.palette import GREY, OTHERS
from plumbob.reports.view.plotly_figure import curve, figure, logarithmic, marks
from plumbob.reports.view.tables import table, table_or_none

Comparison = SimpleNamespace
"""Two studies, each with how it was made and named, and what differs between them."""
Change = Mapping[str, Any]  # scene, method, what, old, new, and growth, relative to the old one
FEW = 25  # rows of a table that is not folded


def write_comparison(comparison: Comparison, file: Path, command: str) -> Path:
    """Write the page, whole or not at all, and return its path; `command` is what reproduces it.
    Raises OSError where its folder cannot be written."""
    return written(render(comparison, command), file.parent, file.name)


def render(comparison: Comparison, command: str) -> str:
    """The page as HTML, in one file."""
    tables = (
        _by_engine(comparison),
        _changes("Verdicts that changed", comparison.verdicts),
        _changes("What vanished, and what is new", comparison.presence),
        _errors(comparison),
        _changes("Costs that moved, in reference step times", comparison.costs),
    )
    return filled(
        "compare.html.jinja",
        lead=_lead(comparison),
        versions=_versions(comparison),
        tables=[*filter(None, tables)],
        figures=[drawn for drawn in (_figure(comparison),) if drawn],
        names=comparison.names,
        made=comparison.made,
        command=command,
    )


def _lead(comparison: Comparison) -> str:
    """A summary of the changes in a sentence or two."""
    moved = {(move["scene"], move["method"]) for move in comparison.errors}
    text = (
        f"Of {plural(len(comparison.both), 'pair')} of a scene and a method that both studies ran, "
        f"{len(moved)} have an error that moved by more than rounding explains, and "
        f"{plural(len(comparison.verdicts), 'verdict')} changed."
    )
    absent = [m["new"] if m["old"] == "yes" else m["old"] for m in comparison.presence]
    gone, come = (sum(m[when] == "no" for m in comparison.presence) for when in ("new", "old"))
    if gone or come:
        text += f" {plural(gone, 'pair')} vanished, and {come} are new."
    if aside := absent.count("not asked for"):
        text += f" {plural(aside, 'other pair')} were asked for in one study alone."
    if comparison.above:
        text += f" {plural(comparison.grown, 'error')} grew by more than {comparison.above}."
    return text


def _versions(comparison: Comparison) -> Table:
    """The versions installed when either study was made."""
    old, new = (source.versions for source in comparison.made)
    names = dict.fromkeys((*old, *new))
    rows = [(name, old.get(name, "unknown"), new.get(name, "unknown")) for name in names]
    return table("compared_versions", rows=rows)


def _engine(change: Change) -> str:
    return str(change["method"]).partition("/")[0]


def _by_engine(comparison: Comparison) -> Table:
    """How many pairs of each engine moved, and by how much the most."""
    rows = {}
    for engine in dict.fromkeys(method.partition("/")[0] for _, method in comparison.both):
        of_engine = [move for move in comparison.errors if _engine(move) == engine]
        shifts = [abs(move["growth"]) for move in of_engine if _known(move["growth"])]
        others = (comparison.verdicts, comparison.presence, comparison.costs)
        rows[engine] = (
            sum(method.partition("/")[0] == engine for _, method in comparison.both),
            len({(move["scene"], move["method"]) for move in of_engine}),
            _percent(max(shifts)).lstrip("+") if shifts else "–",
            *(sum(_engine(move) == engine for move in moves) for moves in others),
        )
    return table("changes_by_engine", rows=rows)


def _changes(caption: str, changes: Sequence[Change]) -> Table | None:
    """Changes as they are; None without any."""
    return table_or_none("changes", caption=caption, rows=changes, few=FEW)


def _errors(comparison: Comparison) -> Table | None:
    """Of each pair whose errors moved, the one that moved most; None where none did."""
    moves: dict[tuple[str, str], list[Change]] = {}
    for move in comparison.errors:
        moves.setdefault((move["scene"], move["method"]), []).append(move)
    most = [(max(of, key=_size), len(of)) for of in moves.values()]
    most.sort(key=lambda pair: -_size(pair[0]))
    rows = [(move, _percent(move["growth"]), count) for move, count in most]
    return table_or_none("errors_moved", rows=rows, few=FEW)


def _figure(comparison: Comparison) -> Figure | None:
    """New errors against old ones, an engine a colour; None where none moved."""
    traces: list[Trace] = []
    known = [move for move in comparison.errors if _known(move["growth"])]
    values = [(_engine(move), float(move["old"]), float(move["new"])) for move in known]
    values = [move for move in values if min(move[1:]) > 0.0]
    if not values:
        return None
    ends = [f(min(move[1:]) if f is min else max(move[1:]) for move in values) for f in (min, max)]
    traces.append(curve(ends, ends, colour=GREY, dash="dot", name="no change"))
    for place, engine in enumerate(dict.fromkeys(move[0] for move in values)):
        points = [(old, new) for of, old, new in values if of == engine]
        old, new = zip(*points, strict=True)
        traces.append(marks(old, new, OTHERS[place % len(OTHERS)], engine))
    return figure(
        "Errors that moved",
        "Above the line an error has grown, below it has become smaller. Each in the unit of its "
        "observable.",
        traces,
        logarithmic("old error / unit"),
        logarithmic("new error / unit"),
        legend=True,
    )


def _known(growth: float | None) -> bool:
    return growth is not None and math.isfinite(growth)


def _size(change: Change) -> float:
    growth = change["growth"]
    return math.inf if growth is None else abs(growth)


def _percent(growth: float | None) -> str:
    if growth is None or not math.isfinite(growth):
        return "–"
    return f"{100.0 * growth:+.2g} %" if abs(growth) < 10.0 else f"{number(1.0 + growth, 2)} times"
