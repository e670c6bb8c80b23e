"""plumbob worst: the parameters in a box for which a method is worst."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.engines.registry import method as find_method
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.arguments.values import default_step

if TYPE_CHECKING:
    from plumbob.engines.method import Method
    from plumbob.engines.sweep.worst import Found
    from plumbob.models.scene import Case

BUDGET = 200  # runs


def command(chosen: argparse.Namespace) -> int:
    """Search, keep what was found, print it with the command that repeats it."""
    from plumbob.engines.box import box
    from plumbob.engines.sweep import store
    from plumbob.engines.sweep.sweep import run_error, runnable
    from plumbob.engines.sweep.worst import search
    from plumbob.reports.commands.arguments.console import progress
    from plumbob.reports.view.sweep.text import error_text, point_text

    method = find_method(chosen.method)
    with values.representable(chosen.changes):
        around = box(chosen.scene, chosen.changes, chosen.within)
    runnable(around, [method])
    score = run_error if chosen.by == "error" else of_tolerance
    with progress() as show:
        answer = search(
            around,
            method,
            chosen.step or default_step(method),
            chosen.budget,
            score,
            progress=lambda done, of, worst: show(f"worst so far {worst:.3g}", done, of),
        )
    store.keep_worst(Path(chosen.out) / store.FILE, answer)
    record = _record(answer)
    values.show(
        chosen,
        record,
        "worst",
        worst=answer,
        control=method.control,
        by=chosen.by,
        held=answer.certificate,
        command=record["command"],
        size=error_text,
        place=point_text,
    )
    return 0


def of_tolerance(case: Case, method: Method, step: float) -> float:
    """The most of its tolerance that an observable's error uses up in a run: above 1 its verdict is
    `off-prediction`; 0 where nothing is judged, infinite where the run diverged or is cut short."""
    from plumbob.engines.study.measurement import measure
    from plumbob.reports.judge.tolerance import used_fraction
    from plumbob.reports.judge.verdict import judge

    run, _ = measure(case, method, step)
    if run.status != "done":
        return math.inf if run.status in ("diverged", "cut-short") else 0.0
    allowed = judge(run, case.system, method, case.system.quantities(case)).tolerances
    return max(
        (used_fraction(run.errors[n], bound) for n, bound in allowed.items()), default=0.0
    )


def _record(worst: Found) -> dict[str, Any]:
    from plumbob.reports.view.sweep.text import repeat_command as repeated

    parameters = {**dict(worst.box.changes), **worst.parameters}
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
        "certificate": worst.certificate,
        "command": repeated(worst.box.scene, worst.method, worst.step, parameters),
    }
