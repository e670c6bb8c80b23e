"""plumbob compare: two studies: their versions, and what has moved."""

from __future__ import annotations

import argparse
import math
import os
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store
from plumbob.engines.study.cost import Key
from plumbob.engines.study.results import Study
from plumbob.models.registry import systems
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.report import html_file
from plumbob.reports.judge.study_verdicts import judge_study
from plumbob.reports.judge.tolerance import round_off

MOVED = 1e-9  # of an error, beside what rounding explains: the same code gives the same bits


def command(chosen: argparse.Namespace) -> int:
    """Print what moved; 1 when a verdict did, or an error grew by more than is allowed."""
    above = math.inf if chosen.above is None else values.fraction("fail-above", chosen.above)
    file = None if chosen.page is None else html_file("page", chosen.page)
    old, new = _study("OLD", chosen.old), _study("NEW", chosen.new)
    moved = {
        "verdicts": _verdicts(old, new),
        "presence": _presence(old, new),  # pairs, or steps of pairs, of one study alone
        "errors": list(_errors(old, new)),  # beyond rounding, and runs that ended otherwise
    }
    made = old.provenance, new.provenance
    rows = [row for part in moved.values() for row in part]
    had, has = (of.versions for of in made)
    versions = [
        _row(("", ""), f"version of {n}", had.get(n, "unknown"), has.get(n, "unknown"))
        for n in {**had, **has}
        if had.get(n, "unknown") != has.get(n, "unknown")
    ]
    if chosen.json:
        values.print_json([*versions, *rows])
    else:
        from plumbob.reports.view.tables import lines

        both_made = dict(zip(("old", "new"), made, strict=True))
        print(*lines("compare", made=both_made, versions=versions, moved=rows), sep="\n")
    grown = sum(row["growth"] is not None and row["growth"] > above for row in rows)
    if file:
        from plumbob.reports.view.site.comparison import Comparison, write_comparison

        ran = [{(c.scene, c.method) for c in study.convergence} for study in (old, new)]
        names, both = (chosen.old, chosen.new), sorted(ran[0] & ran[1])
        of = Comparison(
            names=names, made=made, both=both, above=chosen.above or "", grown=grown, **moved
        )
        words = ["plumbob", "compare", *names, "--page", chosen.page]
        words += [] if chosen.above is None else ["--fail-above", chosen.above]
        page = write_comparison(of, file, shlex.join(words))
        if not chosen.json:
            print(f"page: {page}")
    if any(row["what"] == "verdict" for row in moved["verdicts"]):
        return 1
    if grown and not chosen.json:
        print(f"{grown} errors have grown by more than {chosen.above}")
    return 1 if grown else 0


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


def _verdicts(old: Study, new: Study) -> list[dict[str, Any]]:
    before, after = (
        {pair: judged.whole.verdict for pair, judged in judge_study(study).items()}
        for study in (old, new)
    )
    both = [pair for pair in after if before.get(pair, after[pair]) != after[pair]]
    return [_row(pair, "verdict", before[pair], after[pair]) for pair in both]


def _presence(old: Study, new: Study) -> list[dict[str, Any]]:
    """The pairs, and the steps of pairs, that one of the studies alone has, though it may be that
    the other was not asked for them."""
    had, has = (
        {(c.scene, c.method): [m.step for m in c.measurements] for c in s.convergence}
        for s in (old, new)
    )
    rows = []
    for pair in {**had, **has}:
        if pair not in had or pair not in has:
            ran = _ran(old, pair, pair in had)
            rows.append(_row(pair, "measured", ran, _ran(new, pair, pair in has)))
        elif had[pair] != has[pair]:
            gone, come = _alone(had[pair], has[pair]), _alone(has[pair], had[pair])
            rows.append(_row(pair, "steps of one study alone:", gone, come))
    return rows


def _alone(steps: Sequence[float], others: Sequence[float]) -> str:
    """Steps that the others have not."""
    return ", ".join(f"{step:g}" for step in steps if step not in others) or "none"


def _ran(study: Study, pair: Key, there: bool) -> str:
    """Whether a study ran a pair, or was not asked for it."""
    asked = (
        any(s.name == pair[0] for s in study.scenes),
        any(m.name == pair[1] for m in study.methods),
    )
    return "yes" if there else "no" if all(asked) else "not asked for"


def _errors(old: Study, new: Study) -> Iterator[dict[str, Any]]:
    """The errors that moved by more than rounding explains, and runs that ended otherwise."""
    before = {(m.scene, m.method, m.step): m for c in old.convergence for m in c.measurements}
    known = systems()
    for now in (m for c in new.convergence for m in c.measurements):
        if (then := before.get((now.scene, now.method, now.step))) is None:
            continue
        pair, system = (now.scene, now.method), known[now.scene.partition("/")[0]]
        if then.status != now.status:
            worse = math.inf if then.status == "done" else None
            yield _row(pair, f"run at {now.step:g}", then.status, now.status, worse)
        units = {o.name: o.unit for o in system.observables}
        for name, error in now.errors.items():
            if name not in then.errors:
                continue
            past = then.errors[name].largest
            grown = error.largest - past
            rounded = round_off(then, name, units) + round_off(now, name, units)
            if not abs(grown) <= MOVED * past + rounded:
                growth = grown / past if past > 0.0 else math.inf
                yield _row(pair, f"{name} error at {now.step:g}", past, error.largest, growth)


def _row(pair: Key, what: str, old: Any, new: Any, growth: float | None = None) -> dict[str, Any]:
    """A line of the answer; `growth` is that of an error, relative to the old one."""
    short = (f"{v:.6g}" if isinstance(v, float) else v for v in (old, new))
    keys = ("scene", "method", "what", "old", "new", "growth")
    return dict(zip(keys, (*pair, what, *short, growth), strict=True))
