"""plumbob compare: what has changed between two studies."""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store
from plumbob.engines.study.cost import Key
from plumbob.engines.study.results import Study
from plumbob.models.registry import systems
from plumbob.reports.commands.arguments import values
from plumbob.reports.data.columns import columns_of
from plumbob.reports.judge.study_verdicts import judge_study
from plumbob.reports.judge.tolerance import round_off

# [fraction of an error] largest change that counts as none, beside rounding: the same code gives
# the same bits.
SAME_ERROR = 1e-9


def command(chosen: argparse.Namespace) -> int:
    """Prints what differs between two studies. Returns 1 if a verdict differs, or if an error grew
    by more than the user allows."""
    old = _read_study("OLD", chosen.old)
    new = _read_study("NEW", chosen.new)
    moved = _differences(old, new)
    versions = moved.pop("versions")
    rows = list(chain.from_iterable(moved.values()))
    above = math.inf if chosen.above is None else chosen.above
    growths = [row["growth"] for row in rows if row["growth"] is not None]
    grown = sum(growth > above for growth in growths)
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
        columns=lambda: columns_of("changes", [*versions, *rows]),
        made={"old": old.provenance, "new": new.provenance},
        moved=rows,
        versions=versions,
        verdicts=moved["verdicts"],
        page=page,
        **growth,
    )
    return 1 if moved["verdicts"] or grown else 0


def _read_study(name: str, text: str) -> Study:
    """Returns the study in a file or folder; `text` is its path, or PATH#N for study number N.
    Raises ParameterError for the argument `name`."""
    path, number = text, None
    if "#" in text and not os.path.lexists(text):
        path, _, digits = text.rpartition("#")
        number = values.count(f"the number of the study in {name}", digits)
    place = Path(path)
    study = store.load(place / store.FILE if place.is_dir() else place, number)
    if study is None:
        raise ParameterError(name, text, "where `plumbob validate` has stored a study")
    return study


def _differences(old: Study, new: Study) -> dict[str, list[dict[str, Any]]]:
    """Returns the rows of what differs between two studies, by kind. Errors whose difference is
    rounding do not differ."""
    # A value that only one study has is compared with these.
    absent = {"versions": "unknown", "verdicts": None, "presence": "no"}
    old_values = dict(_compared_values(old))
    new_values = dict(_compared_values(new))
    differences: dict[str, list[dict[str, Any]]] = {kind: [] for kind in (*absent, "errors")}
    for key in {**old_values, **new_values}:
        kind, pair, name = key
        measured = ("presence", pair, "measured")
        pair_in_one_study = (measured in old_values) != (measured in new_values)
        old_value = old_values.get(key, absent.get(kind))
        new_value = new_values.get(key, absent.get(kind))
        if old_value == new_value or old_value is None or new_value is None:
            continue
        if pair_in_one_study and key != measured:
            continue
        growth = math.inf if old_value == "done" else None
        if isinstance(old_value, tuple):
            growth = _growth(old_value, new_value)
            if growth is None:
                continue
            old_value, new_value = f"{old_value[0]:.6g}", f"{new_value[0]:.6g}"
        row = {"scene": pair[0], "method": pair[1], "what": name, "old": old_value}
        differences[kind].append(row | {"new": new_value, "growth": growth})
    return differences


def _growth(old: tuple[float, float], new: tuple[float, float]) -> float | None:
    """Returns the growth of an error as a fraction of the old error; None if the difference is
    rounding. `old` and `new` are an error and how far rounding may change it."""
    old_error, old_rounding = old
    new_error, new_rounding = new
    grown = new_error - old_error
    if abs(grown) <= SAME_ERROR * old_error + old_rounding + new_rounding:
        return None
    return grown / old_error if old_error > 0.0 else math.inf


def _compared_values(study: Study) -> Iterator[tuple[tuple[str, Key, str], Any]]:
    """Gives all values of a study that are compared. The key of a value is its kind, its pair of
    scene and method, and its name. The value of an error is the error and how far rounding may
    change it."""
    for name, version in study.provenance.versions.items():
        yield ("versions", ("", ""), f"version of {name}"), version
    judged = judge_study(study)
    known = systems()
    for convergence in study.convergence:
        pair = convergence.scene, convergence.method
        system = known[convergence.scene.partition("/")[0]]
        units = {observable.name: observable.unit for observable in system.observables}
        yield ("verdicts", pair, "verdict"), judged[pair].whole.verdict
        yield ("presence", pair, "measured"), "yes"
        for run in convergence.measurements:
            yield ("presence", pair, f"measured at {run.step:g}"), "yes"
            yield ("errors", pair, f"run at {run.step:g}"), run.status
            for name, error in run.errors.items():
                key = ("errors", pair, f"{name} error at {run.step:g}")
                yield key, (error.largest, round_off(run, name, units))
