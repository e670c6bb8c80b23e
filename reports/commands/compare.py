"""plumbob compare: two studies: their versions, and what has moved."""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store
from plumbob.engines.study.cost import Key
from plumbob.engines.study.results import Study
from plumbob.models.registry import systems
from plumbob.reports.commands.arguments import values
from plumbob.reports.judge.study_verdicts import judge_study
from plumbob.reports.judge.tolerance import round_off

MOVED = 1e-9  # of an error, beside what rounding explains: the same code gives the same bits


def command(chosen: argparse.Namespace) -> int:
    """Print what moved; 1 when a verdict did, or an error grew by more than is allowed."""
    old = _study("OLD", chosen.old)
    new = _study("NEW", chosen.new)
    moved = _moved(old, new)
    versions = moved.pop("versions")
    rows = [row for part in moved.values() for row in part]
    above = math.inf if chosen.above is None else chosen.above
    grown = sum(row["growth"] is not None and row["growth"] > above for row in rows)
    growth = {"above": chosen.above, "grown": grown}
    page: Path | None = None
    if chosen.page:
        from plumbob.reports.view.site.comparison import write_comparison

        studies = [(chosen.old, old), (chosen.new, new)]
        page = write_comparison(chosen.page, studies, moved, chosen.line, **growth)
    values.show(
        chosen,
        [*versions, *rows],
        "compare",
        made={"old": old.provenance, "new": new.provenance},
        moved=rows,
        versions=versions,
        verdicts=moved["verdicts"],
        page=page,
        **growth,
    )
    return 1 if moved["verdicts"] or grown else 0


def _study(name: str, text: str) -> Study:
    """The study in a file or folder, of the number behind it."""
    path, number = text, None
    if "#" in text and not os.path.lexists(text):
        path, _, digits = text.rpartition("#")
        number = values.count(f"the number of the study in {name}", digits)
    place = Path(path)
    study = store.load(place / store.FILE if place.is_dir() else place, number)
    if study is None:
        raise ParameterError(name, text, "where `plumbob validate` has stored a study")
    return study


def _moved(old: Study, new: Study) -> dict[str, list[dict[str, Any]]]:
    """Rows of what differs by kind; errors beyond what rounding explains."""
    absent = {"versions": "unknown", "verdicts": None, "presence": "no"}  # of one study alone
    had = dict(_facts(old))
    has = dict(_facts(new))
    moved: dict[str, list[dict[str, Any]]] = {kind: [] for kind in (*absent, "errors")}
    for kind, pair, what in {**had, **has}:
        key = (kind, pair, what)
        whole = ("presence", pair, "measured")
        was, now = (facts.get(key, absent.get(kind)) for facts in (had, has))
        alone = (whole in had) != (whole in has)
        if was == now or was is None or now is None or (alone and key != whole):
            continue
        growth = math.inf if was == "done" else None
        if isinstance(was, tuple):
            (past, blurred), (largest, blurs) = was, now
            grown = largest - past
            if abs(grown) <= MOVED * past + blurred + blurs:
                continue
            growth = grown / past if past > 0.0 else math.inf
            was = f"{past:.6g}"
            now = f"{largest:.6g}"
        row = {"scene": pair[0], "method": pair[1], "what": what, "old": was, "new": now}
        moved[kind].append(row | {"growth": growth})
    return moved


def _facts(study: Study) -> Iterator[tuple[tuple[str, Key, str], Any]]:
    """All that is compared of a study, by kind, pair and name: an error with what rounding makes of
    it."""
    for name, version in study.provenance.versions.items():
        yield ("versions", ("", ""), f"version of {name}"), version
    judged = judge_study(study)
    known = systems()
    for convergence in study.convergence:
        pair = convergence.scene, convergence.method
        units = {o.name: o.unit for o in known[pair[0].partition("/")[0]].observables}
        yield ("verdicts", pair, "verdict"), judged[pair].whole.verdict
        yield ("presence", pair, "measured"), "yes"
        for run in convergence.measurements:
            yield ("presence", pair, f"measured at {run.step:g}"), "yes"
            yield ("errors", pair, f"run at {run.step:g}"), run.status
            for name, error in run.errors.items():
                rounded = round_off(run, name, units)
                yield (
                    ("errors", pair, f"{name} error at {run.step:g}"),
                    (error.largest, rounded),
                )
