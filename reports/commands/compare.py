"""plumbob compare: two studies: which errors, verdicts and costs have moved."""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store
from plumbob.engines.study.measurement import floor
from plumbob.engines.study.results import Study
from plumbob.reports.commands import values
from plumbob.reports.judge.verdict import judge_study

MOVED = 1e-3  # of an error, beside what rounding explains: the same code gives the same bits
COSTS_MORE = 1.25  # of a cost in reference step times, beyond the quartiles of both


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    word = "a results folder or a file of stored studies; FILE#N for the study of that number"
    parser.add_argument("old", metavar="OLD", help=word)
    parser.add_argument("new", metavar="NEW", help="the same")
    parser.add_argument("--json", action="store_true", help="print JSON")


def command(chosen: argparse.Namespace) -> int:
    """Print what moved; 1 when a verdict did."""
    old, new = _study("OLD", chosen.old), _study("NEW", chosen.new)
    moved = [*_verdicts(old, new), *_errors(old, new), *_costs(old, new)]
    if chosen.json:
        json.dump(values.plain(moved), sys.stdout, indent=1)
        print()
    else:
        for row in moved:
            print(f"{row['scene']} {row['method']}: {row['what']} {row['old']} -> {row['new']}")
        if not moved:
            print("nothing has moved")
    return 1 if any(row["what"] == "verdict" for row in moved) else 0


def _study(name: str, text: str) -> Study:
    path, number = text, None
    if "#" in text and not os.path.lexists(text):
        path, _, digits = text.rpartition("#")
        number = values.count(f"the number of the study in {name}", digits)
    file = Path(path) / store.FILE if Path(path).is_dir() else Path(path)
    found = store.load(file, number)
    if found is None:
        raise ParameterError(name, text, "where `plumbob validate` has stored a study")
    return found


def _verdicts(old: Study, new: Study) -> list[dict[str, Any]]:
    before, after = _judged(old), _judged(new)
    return [
        _row(pair, "verdict", before[pair], after[pair])
        for pair in after
        if pair in before and before[pair] != after[pair]
    ]


def _judged(study: Study) -> dict[tuple[str, str], str]:
    return {pair: found.whole.verdict for pair, found in judge_study(study).items()}


def _errors(old: Study, new: Study) -> list[dict[str, Any]]:
    before = {(m.scene, m.method, m.step): m for c in old.convergence for m in c.measurements}
    rows = []
    for now in (m for c in new.convergence for m in c.measurements):
        then = before.get((now.scene, now.method, now.step))
        for name, error in now.errors.items():
            if then is None or name not in then.errors:
                continue
            past = then.errors[name]
            allowed = MOVED * past.largest + floor(past, then.steps) + floor(error, now.steps)
            if abs(error.largest - past.largest) > allowed:
                what = f"{name} error at {now.step:g}"
                rows.append(_row((now.scene, now.method), what, past.largest, error.largest))
    return rows


def _costs(old: Study, new: Study) -> list[dict[str, Any]]:
    rows = []
    for pair, cost in new.costs.items():
        past = old.costs.get(pair)
        if past is None:
            continue
        apart = cost.low > past.high or cost.high < past.low
        if apart and max(cost.ratio / past.ratio, past.ratio / cost.ratio) > COSTS_MORE:
            rows.append(_row(pair, "cost of a step [reference step times]", past.ratio, cost.ratio))
    return rows


def _row(pair: tuple[str, str], what: str, old: Any, new: Any) -> dict[str, Any]:
    short = [f"{v:.4g}" if isinstance(v, float) else v for v in (old, new)]
    return {"scene": pair[0], "method": pair[1], "what": what, "old": short[0], "new": short[1]}
