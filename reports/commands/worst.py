"""plumbob worst: search a box of parameters for the largest error of a method."""

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

BUDGET = 200  # largest number of runs


def command(chosen: argparse.Namespace) -> int:
    """Searches for the worst parameters, stores them, and prints them with the command that repeats
    their run."""
    from plumbob.engines.box import box
    from plumbob.engines.sweep import store
    from plumbob.engines.sweep.sweep import run_error, runnable
    from plumbob.engines.sweep.worst import search
    from plumbob.reports.commands.arguments.console import progress
    from plumbob.reports.view.sweep.text import error_text, point_text

    method = find_method(chosen.method)
    with values.representable(chosen.changes):
        parameter_box = box(chosen.scene, chosen.changes, chosen.within)
    runnable(parameter_box, [method])
    score = run_error if chosen.by == "error" else tolerance_fraction
    with progress() as show:

        def show_worst(runs: int, budget: int, worst_score: float) -> None:
            show(f"worst so far {worst_score:.3g}", runs, budget)

        step = chosen.step or default_step(method)
        answer = search(parameter_box, method, step, chosen.budget, score, show_worst)
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


def tolerance_fraction(case: Case, method: Method, step: float) -> float:
    """Returns the largest fraction of its tolerance that the error of an observable reaches in a
    run. A fraction above 1 means the verdict `off-prediction`. The fraction is 0 if nothing is
    judged, and infinite if the run diverged or was cut short."""
    from plumbob.engines.study.measurement import measure
    from plumbob.reports.judge.tolerance import used_fraction
    from plumbob.reports.judge.verdict import judge

    run, _ = measure(case, method, step)
    if run.status != "done":
        return math.inf if run.status in ("diverged", "cut-short") else 0.0
    quantities = case.system.quantities(case)
    tolerances = judge(run, case.system, method, quantities).tolerances
    fractions = (
        used_fraction(run.errors[name], tolerance) for name, tolerance in tolerances.items()
    )
    return max(fractions, default=0.0)


def _record(worst: Found) -> dict[str, Any]:
    """Returns the JSON data of the worst place."""
    from plumbob.reports.view.sweep.text import repeat_command as command_line

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
        "command": command_line(worst.box.scene, worst.method, worst.step, parameters),
    }
