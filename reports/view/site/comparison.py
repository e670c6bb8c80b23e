"""The page of two studies compared: versions, what moved beyond scatter, vanished or is new."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plumbob.engines.study.provenance import Provenance
from plumbob.reports.view.content import Cell, Figure, Table, row
from plumbob.reports.view.notation import number, plural
from plumbob.reports.view.page import filled, written
from plumbob.reports.view.palette import GREY, OTHERS
from plumbob.reports.view.traces import Trace, curve, figure, logarithmic, marks

Change = Mapping[str, Any]  # scene, method, what, old, new, and growth, relative to the old one
FEW = 25  # rows of a table that is not folded
PAIR = ("scene", "method")


@dataclass(frozen=True)
class Comparison:
    """Two studies, each with how it was made and named, and what differs between them."""

    names: tuple[str, str]  # as the command had them
    made: tuple[Provenance, Provenance]
    versions: Sequence[Change]
    verdicts: Sequence[Change]
    presence: Sequence[Change]  # pairs, or steps of pairs, of one study alone
    errors: Sequence[Change]  # beyond rounding, and runs that ended otherwise
    costs: Sequence[Change]  # beyond the quartiles of both
    both: Sequence[tuple[str, str]]  # scenes and methods of both studies
    above: str = ""  # the growth of an error that was not to be exceeded
    grown: int = 0  # errors that did


def write_comparison(found: Comparison, file: Path, command: str) -> Path:
    """Write the page, whole or not at all, and return its path; `command` is what reproduces it.
    Raises OSError where its folder cannot be written."""
    return written(render(found, command), file.parent, file.name)


def render(found: Comparison, command: str) -> str:
    """The page as HTML, in one file."""
    tables = (_by_engine(found), _changes("Verdicts that changed", found.verdicts),
              _changes("What vanished, and what is new", found.presence), _errors(found),
              _changes("Costs that moved, in reference step times", found.costs))  # fmt: skip
    return filled(
        "compare.html.jinja",
        lead=_lead(found),
        versions=_versions(found),
        tables=[table for table in tables if table is not None],
        figures=[one for one in (_figure(found),) if one is not None],
        names=found.names,
        made=found.made,
        command=command,
    )


def _lead(found: Comparison) -> str:
    """What changed, in a sentence or two."""
    moved = {(one["scene"], one["method"]) for one in found.errors}
    said = (
        f"Of {plural(len(found.both), 'pair')} of a scene and a method that both studies ran, "
        f"{len(moved)} have an error that moved by more than rounding explains, and "
        f"{plural(len(found.verdicts), 'verdict')} changed."
    )
    gone, come = (
        sum(one["what"] == "measured" and one[when] == "yes" for one in found.presence)
        for when in ("old", "new")
    )
    if gone or come:
        said += f" {plural(gone, 'pair')} vanished, and {come} are new."
    if found.above:
        said += f" {plural(found.grown, 'error')} grew by more than {found.above}."
    return said


def _versions(found: Comparison) -> Table:
    """What was installed when either study was made."""
    old, new = (one.versions for one in found.made)
    rows = []
    for name in dict.fromkeys((*old, *new)):
        then, now = old.get(name, "unknown"), new.get(name, "unknown")
        said = Cell("changed", "pass surprise") if then != now else Cell("the same")
        rows.append((then == now, row(Cell(name, "text"), then, now, said)))
    rows.sort(key=lambda one: one[0])
    return Table("Versions", ("package", "old", "new", ""), tuple(cells for _, cells in rows))


def _engine(change: Change) -> str:
    return str(change["method"]).partition("/")[0]


def _by_engine(found: Comparison) -> Table:
    """How many pairs of each engine moved, and by how much the most."""
    rows = []
    for engine in dict.fromkeys(method.partition("/")[0] for _, method in found.both):
        own = [one for one in found.errors if _engine(one) == engine]
        pairs = {(one["scene"], one["method"]) for one in own}
        shifts = [abs(one["growth"]) for one in own if _known(one["growth"])]
        rows.append(
            row(
                Cell(engine, "text"),
                Cell(str(sum(m.partition("/")[0] == engine for _, m in found.both)), "number"),
                Cell(str(len(pairs)), "number"),
                Cell(_percent(max(shifts)).lstrip("+") if shifts else "–", "number"),
                Cell(str(sum(_engine(one) == engine for one in found.verdicts)), "number"),
                Cell(str(sum(_engine(one) == engine for one in found.presence)), "number"),
                Cell(str(sum(_engine(one) == engine for one in found.costs)), "number"),
            )
        )
    heads = ("engine", "pairs in both studies", "with an error that moved", "the most it moved by",
             "verdicts changed", "in one study alone", "costs moved")  # fmt: skip
    note = (
        "An error moved if it differs by more than 10⁻⁹, relative, and what rounding explains of "
        "both; a cost, if the quartiles of both studies lie apart by more than a quarter, and the "
        "same way on two of three scenes of the method; by a factor of two where it has fewer."
    )
    return Table("What changed, engine by engine", heads, tuple(rows), note)


def _changes(caption: str, changes: Sequence[Change]) -> Table | None:
    """Changes as they are; None without any."""
    if not changes:
        return None
    rows = tuple(
        row(Cell(one["scene"], "text"), Cell(one["method"], "name"), one["what"],
            Cell(str(one["old"]), "number"), Cell(str(one["new"]), "number"))
        for one in changes
    )  # fmt: skip
    return Table(f"{caption}: {len(rows)}", (*PAIR, "what", "old", "new"), rows,
                 folded=len(rows) > FEW)  # fmt: skip


def _errors(found: Comparison) -> Table | None:
    """Of each pair whose errors moved, the one that moved most; None where none did."""
    worst: dict[tuple[str, str], Change] = {}
    counted: dict[tuple[str, str], int] = {}
    for one in found.errors:
        pair = one["scene"], one["method"]
        counted[pair] = counted.get(pair, 0) + 1
        if pair not in worst or _size(one) > _size(worst[pair]):
            worst[pair] = one
    if not worst:
        return None
    rows = tuple(
        row(Cell(one["scene"], "text"), Cell(one["method"], "name"), one["what"],
            Cell(str(one["old"]), "number"), Cell(str(one["new"]), "number"),
            Cell(_percent(one["growth"]), "number"), Cell(str(counted[pair]), "number"))
        for pair, one in sorted(worst.items(), key=lambda item: -_size(item[1]))
    )  # fmt: skip
    heads = (*PAIR, "what moved most", "old", "new", "change", "errors that moved")
    return Table(f"Errors that moved, the largest change of each pair: {len(rows)}", heads, rows,
                 folded=len(rows) > FEW)  # fmt: skip


def _figure(found: Comparison) -> Figure | None:
    """New errors against old ones, an engine a colour; None where none moved."""
    traces: list[Trace] = []
    known = [one for one in found.errors if _known(one["growth"])]
    values = [(_engine(one), float(one["old"]), float(one["new"])) for one in known]
    values = [one for one in values if min(one[1:]) > 0.0]
    if not values:
        return None
    ends = [f(min(one[1:]) if f is min else max(one[1:]) for one in values) for f in (min, max)]
    traces.append(curve(ends, ends, colour=GREY, dash="dot", name="no change"))
    for place, engine in enumerate(dict.fromkeys(one[0] for one in values)):
        own = [(old, new) for of, old, new in values if of == engine]
        old, new = zip(*own, strict=True)
        traces.append(marks(old, new, OTHERS[place % len(OTHERS)], engine))
    return figure(
        "Errors that moved",
        "Above the line an error has grown, below it has become smaller. Each in the unit of its "
        "observable.",
        traces, logarithmic("old error / unit"), logarithmic("new error / unit"), legend=True,
    )  # fmt: skip


def _known(growth: float | None) -> bool:
    return growth is not None and math.isfinite(growth)


def _size(change: Change) -> float:
    growth = change["growth"]
    return math.inf if growth is None else abs(growth)


def _percent(growth: float | None) -> str:
    if growth is None or not math.isfinite(growth):
        return "–"
    return f"{100.0 * growth:+.2g} %" if abs(growth) < 10.0 else f"{number(1.0 + growth, 2)} times"
