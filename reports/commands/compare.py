"""plumbob compare: two studies, or two runs of benchmarks: versions, and what has moved."""

from __future__ import annotations

import argparse
import math
import os
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store
from plumbob.engines.study.cost import Cost, Key
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.study.results import Study
from plumbob.models.registry import systems
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.report import html_file
from plumbob.reports.judge import benchmarks
from plumbob.reports.judge.benchmarks import BenchmarkRun
from plumbob.reports.judge.study_verdicts import judge_study
from plumbob.reports.judge.tolerance import round_off

MOVED = 1e-9  # of an error, beside what rounding explains: the same code gives the same bits
COSTS_MORE = 1.25  # of a cost in reference step times, beyond the quartiles of both
# Of a method that is timed on fewer than SEVERAL scenes: between two studies on a machine that did
# nothing else, and ten other things, costs on single scenes differed by up to 1.9 times.
SEVERAL, ALONE_MORE = 3, 2.0


def command(chosen: argparse.Namespace) -> int:
    """Print what moved; 1 when a verdict did, or an error grew by more than is allowed."""
    above = math.inf if chosen.above is None else values.fraction("fail-above", chosen.above)
    file = None if chosen.page is None else html_file("page", chosen.page)
    runs = _benchmark("OLD", chosen.old), _benchmark("NEW", chosen.new)
    if runs != (None, None):
        return _benchmarks(chosen, runs, above)
    old, new = _study("OLD", chosen.old), _study("NEW", chosen.new)
    parts = _verdicts(old, new), _presence(old, new), list(_errors(old, new)), _costs(old, new)
    made = old.provenance, new.provenance
    moved = [row for part in parts for row in part]
    grown = _print(chosen, made, moved, above)
    if file:
        from plumbob.reports.view.site.comparison import Comparison, write_comparison

        ran = [{(c.scene, c.method) for c in study.convergence} for study in (old, new)]
        verdicts, presence, errors, costs = parts
        comparison = Comparison(
            names=(chosen.old, chosen.new),  # as the command had them
            made=made,
            versions=_versions(*made),
            verdicts=verdicts,
            presence=presence,  # pairs, or steps of pairs, of one study alone
            errors=errors,  # beyond rounding, and runs that ended otherwise
            costs=costs,  # beyond the quartiles of both
            both=sorted(ran[0] & ran[1]),  # scenes and methods of both studies
            above=chosen.above or "",  # the growth of an error that was not to be exceeded
            grown=grown,  # errors that did
        )
        page = write_comparison(comparison, file, _words(chosen))
        if not chosen.json:
            print(f"page: {page}")
    if any(row["what"] == "verdict" for row in moved):
        return 1
    if grown and not chosen.json:
        print(f"{grown} errors have grown by more than {chosen.above}")
    return 1 if grown else 0


def _words(chosen: argparse.Namespace) -> str:
    """The command that writes the page again."""
    words = ["plumbob", "compare", chosen.old, chosen.new, "--page", chosen.page]
    words += [] if chosen.above is None else ["--fail-above", chosen.above]
    return shlex.join(words)


def _versions(old: Provenance, new: Provenance) -> list[dict[str, Any]]:
    names = dict.fromkeys((*old.versions, *new.versions))
    both = ((n, old.versions.get(n, "unknown"), new.versions.get(n, "unknown")) for n in names)
    return [_row(("", ""), f"version of {n}", was, now) for n, was, now in both if was != now]


def _print(
    chosen: argparse.Namespace,
    made: tuple[Provenance, Provenance],
    moved: Sequence[Mapping[str, Any]],
    above: float,
) -> int:
    """Print what the old one and the new one were made with, and what has moved; returns how many
    have grown by more than is allowed."""
    from plumbob.reports.view.tables import lines

    versions = _versions(*made)
    if chosen.json:
        values.print_json([*versions, *moved])
    else:
        both = dict(zip(("old", "new"), made, strict=True))
        print(*lines("compare", made=both, versions=versions, moved=moved), sep="\n")
    return sum(row["growth"] is not None and row["growth"] > above for row in moved)


def _benchmarks(
    chosen: argparse.Namespace, runs: tuple[BenchmarkRun | None, BenchmarkRun | None], above: float
) -> int:
    """Print which ratios moved; 1 when one got worse by more than is allowed."""
    old, new = runs
    if not old or not new:
        name, text = ("NEW", chosen.new) if old else ("OLD", chosen.old)
        raise ParameterError(name, text, "a file of benchmarks, as the other one is")
    if chosen.page is not None:
        raise ParameterError("page", chosen.page, "left out: benchmarks have none")
    rows = []
    for was, now in benchmarks.moved(old, new, COSTS_MORE):
        worse = was.median / now.median if now.least else now.median / was.median
        rows.append(_row(("", ""), now.name, was.median, now.median, worse - 1.0))
    names = [[r.name for r in run.ratios] for run in (old, new)]
    rows += [_row(("", ""), name, "measured", "no") for name in names[0] if name not in names[1]]
    rows += [_row(("", ""), name, "no", "measured") for name in names[1] if name not in names[0]]
    return int(bool(_print(chosen, (old.made, new.made), rows, above)))


def _benchmark(name: str, text: str) -> BenchmarkRun | None:
    """The run of benchmarks that is meant, the last one without a number; None for a study."""
    path, number = _numbered(name, text)
    if not benchmarks.keeps_benchmarks(path):
        return None
    runs = benchmarks.stored(path)
    if number is not None and not 1 <= number <= len(runs):
        raise ParameterError(name, text, f"with a number of a run from 1 to {len(runs)}")
    return runs[-1 if number is None else number - 1]


def _numbered(name: str, text: str) -> tuple[Path, int | None]:
    """A path and the number behind it."""
    path, number = text, None
    if "#" in text and not os.path.lexists(text):
        path, _, digits = text.rpartition("#")
        number = values.count(f"the number of the study in {name}", digits)
    return Path(path), number


def _study(name: str, text: str) -> Study:
    path, number = _numbered(name, text)
    file = path / store.FILE if path.is_dir() else path
    study = store.load(file, number)
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
    before, after = (
        {(c.scene, c.method): [m.step for m in c.measurements] for c in s.convergence}
        for s in (old, new)
    )
    rows = []
    for pair in dict.fromkeys((*before, *after)):
        had, has = before.get(pair), after.get(pair)
        if had is None or has is None:
            rows.append(_row(pair, "measured", _presence_of(old, pair), _presence_of(new, pair)))
        elif had != has:
            gone, come = (
                ", ".join(f"{step:g}" for step in steps if step not in others) or "none"
                for steps, others in ((had, has), (has, had))
            )
            rows.append(_row(pair, "steps of one study alone:", gone, come))
    return rows


def _presence_of(study: Study, pair: tuple[str, str]) -> str:
    if any((c.scene, c.method) == pair for c in study.convergence):
        return "yes"
    asked = {s.name for s in study.scenes}, {m.name for m in study.methods}
    return "no" if pair[0] in asked[0] and pair[1] in asked[1] else "not asked for"


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


def _costs(old: Study, new: Study) -> list[dict[str, Any]]:
    """The costs that moved, of methods that moved the same way on two scenes of three: by what else
    a machine does, costs on single scenes move too."""
    by_method: dict[str, list[tuple[Key, Cost, Cost]]] = {}
    for pair, cost in new.costs.items():
        if past := old.costs.get(pair):
            by_method.setdefault(pair[1], []).append((pair, past, cost))
    rows = []
    for timed in by_method.values():
        more = COSTS_MORE if len(timed) >= SEVERAL else ALONE_MORE
        higher = [each for each in timed if each[2].low > each[1].high and _times(*each[1:]) > more]
        lower = [
            each for each in timed if each[2].high < each[1].low and _times(*each[1:]) < 1 / more
        ]
        moved = max(higher, lower, key=len)
        if 3 * len(moved) >= 2 * len(timed):
            what = "cost of a step [reference step times]"
            rows += [_row(pair, what, past.ratio, cost.ratio) for pair, past, cost in moved]
    return rows


def _times(past: Cost, cost: Cost) -> float:
    return cost.ratio / past.ratio


def _row(pair: Key, what: str, old: Any, new: Any, growth: float | None = None) -> dict[str, Any]:
    """A line of the answer; `growth` is that of an error, relative to the old one."""
    short = (f"{v:.6g}" if isinstance(v, float) else v for v in (old, new))
    keys = ("scene", "method", "what", "old", "new", "growth")
    return dict(zip(keys, (*pair, what, *short, growth), strict=True))
