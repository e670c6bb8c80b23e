"""plumbob worst: the parameters in a box for which a method is worst."""

from __future__ import annotations

import argparse
import json
import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.engines.registry import method as find_method
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.sweep import side

if TYPE_CHECKING:
    from plumbob.engines.method import Method
    from plumbob.engines.sweep.worst import Found
    from plumbob.models.scene import Case

BUDGET = 200  # runs


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("scene", metavar="SCENE", help="system/case, or a system's default case")
    parser.add_argument("method", metavar="METHOD", help="engine/name: see `plumbob list methods`")
    parser.add_argument(
        "--within",
        metavar="NAME=LO:HI[:log]",
        action="append",
        required=True,
        help="a parameter and where to look (SI units, radians), with log by ratios; may be "
        "repeated",
    )
    parser.add_argument("--step", metavar="DT", help="step [s], or rtol (default: 1 ms, tightest)")
    parser.add_argument(
        "--budget", metavar="RUNS", default=str(BUDGET), help=f"runs at most (default: {BUDGET})"
    )
    parser.add_argument(
        "--by",
        choices=("error", "tolerance"),
        default="error",
        help="the largest relative error (default), or the largest error over what is allowed: a "
        "value above 1 is a defect of the engine, or of plumbob",
    )
    values.add_changes(parser)
    values.name_parameters(parser)
    parser.add_argument("--out", metavar="DIR", default="plumbob-out", help="where it is kept")
    parser.add_argument("--json", action="store_true", help="print JSON")


def command(chosen: argparse.Namespace) -> int:
    """Search, keep what was found, print it with the command that repeats it."""
    from plumbob.engines.sweep import store
    from plumbob.engines.sweep.box import box
    from plumbob.engines.sweep.sweep import run_error, runnable
    from plumbob.engines.sweep.worst import search
    from plumbob.reports.commands.validate import progress

    sides = [side("within", text)[0] for text in chosen.within]
    method, changed = find_method(chosen.method), values.changes(chosen.changes)
    budget = values.count("budget", chosen.budget)
    finest = method.step_sizes[-1:] or (1e-3,)
    step = values.positive_number("step", chosen.step) if chosen.step else finest[0]
    with values.representable(changed):
        around = box(chosen.scene, changed, sides)
    runnable(around, [method])
    score = run_error if chosen.by == "error" else of_tolerance
    with progress() as show:
        answer = search(
            around,
            method,
            step,
            budget,
            score,
            progress=lambda done, of, worst: show(f"worst so far {worst:.3g}", done, of),
        )
    store.keep_worst(Path(chosen.out) / store.FILE, answer)
    if chosen.json:
        json.dump(values.plain(_as_json(answer)), sys.stdout, indent=1)
        print()
    else:
        print(*_lines(answer, method, chosen.by), sep="\n")
    return 0


def of_tolerance(case: Case, method: Method, step: float) -> float:
    """The most of its tolerance that an observable's error uses up in a run: above 1 its verdict is
    `off-prediction`; 0 where nothing is judged, infinite where the run diverged or is cut short."""
    from plumbob.engines.study.measurement import measure
    from plumbob.reports.judge.tolerance import used
    from plumbob.reports.judge.verdict import judge

    run, _ = measure(case, method, step)
    if run.status != "done":
        return math.inf if run.status in ("diverged", "cut-short") else 0.0
    allowed = judge(run, case.system, method, case.system.quantities(case)).tolerances
    return max((used(run.errors[n], bound) for n, bound in allowed.items()), default=0.0)


def _lines(worst: Found, method: Method, by: str) -> list[str]:
    from plumbob.reports.view.notation import number, plural
    from plumbob.reports.view.notation import step as step_text
    from plumbob.reports.view.sweep.text import place, size

    at = step_text(worst.step, method.control)
    lines = [
        f"{worst.box.scene} with {worst.method} at {at}: the worst of {plural(worst.runs, 'run')}",
        f"  {place(worst.parameters)}",
        f"  relative error {size(worst.error)}",
    ]
    if by == "tolerance":
        lines.append(f"  uses {number(worst.score)} of its tolerance")
    if worst.without:
        lines.append(f"  {plural(worst.without, 'run')} had no exact answer, or no model")
    lines.append(f"  the exact answer there: {_certificate(worst)}")
    lines.append(f"  {_repeated(worst)}")
    return lines


def _certificate(worst: Found) -> str:
    """How sure the exact answer is, in words."""
    from plumbob.reports.view.notation import relative, short

    held = worst.certificate
    if held is None:
        return "no other computation runs this scene"
    sure = "confirmed" if worst.certain else "not confirmed"
    return (
        f"{sure}: {held.method} at {short(held.step)} ends within {relative(held.distance)} of it"
    )


def _repeated(worst: Found) -> str:
    from plumbob.reports.view.sweep.text import command as repeated

    parameters = {**dict(worst.box.changes), **worst.parameters}
    return repeated(worst.box.scene, worst.method, worst.step, parameters)


def _as_json(worst: Found) -> dict[str, Any]:
    return {
        "scene": worst.box.scene,
        "method": worst.method,
        "step": worst.step,
        "parameters": dict(worst.parameters),
        "error": worst.error,
        "score": worst.score,
        "runs": worst.runs,
        "without_error": worst.without,
        "certain": worst.certain,
        "certificate": None if worst.certificate is None else asdict(worst.certificate),
        "command": _repeated(worst),
    }
