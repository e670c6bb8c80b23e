"""The figures of an audit's answer that its template needs beside the audit itself."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.reference import RESOLVED
from plumbob.engines.audit.step_errors import TARGETS, StepComparison, horizon
from plumbob.engines.own_motion import OUT_OF_TIME
from plumbob.reports.advice.work_precision import pareto_front

SHOWN = 5  # errors of a halving
COURSES = 4  # steps of the own integrator in the figure over time


def motion_of(audit: Audit) -> dict[str, Any]:
    """Results of an audit whose motion is certified: `runs` of the own integrator at the own step
    and halves of it, their `errors` [m] where the motion is known, those that it `resolved`,
    from `known` [m] on, and their mean `ratio`; the largest step [s] that `holds` to the end, and
    whether the own one has `diverged`; `horizons`, errors [m] and up to when [s] the most accurate
    step keeps them (None: to the end); contacts and limits that begin or cease to act in a second;
    and what to choose."""
    if audit.found is None:
        return {}
    steps = audit.found
    index = audit.found.index
    reference = audit.reference
    runs = [r for r in steps.steps if r.integrator == audit.integrator and r.step <= audit.step]
    errors = [r.at(index) for r in runs]
    known = RESOLVED * audit.uncertainty
    resolved = [error for error in errors if error > known][:SHOWN]
    ends = {target: horizon(steps, reference, audit.script, target) for target in TARGETS[1:3]}
    holding = (r.step for r, error in zip(runs, errors, strict=True) if math.isfinite(error))
    course = reference.course
    return {
        "targets": TARGETS,
        "runs": runs,
        "errors": errors,
        "known": known,
        "resolved": resolved,
        "ratio": mean_ratio(resolved) if resolved[1:] else None,
        "holds": next(holding, None),
        "diverged": bool(steps.own.why) and math.isinf(audit.error),
        "horizons": [
            (target, None if math.isinf(end) else end) for target, end in ends.items()
        ],
        "event_rate": len(course.events) / max(course.until, audit.script.period),
        "out_of_time": OUT_OF_TIME in reference.why,
        "courses": [(r.integrator, r.step, _drawn(r.errors)) for r in runs[:COURSES]],
        "uncertainty": _drawn(reference.uncertainty),
        **_choices(audit, steps),
        **_costs(steps),
    }


def _choices(audit: Audit, steps: StepComparison) -> dict[str, Any]:
    """The cheapest for an error that is smaller than the own step's, and what saves most where that
    is enough."""
    least = audit.error + audit.uncertainty
    better = (choice for choice in steps.cheapest if choice.target < audit.error)
    enough = [choice for choice in steps.cheapest if choice.target >= least][-1:]
    saving = (c for c in enough if c.cost is not None and c.cost.saves and audit.complete)
    return {"better": next(better, None), "enough": next(saving, None)}


def _costs(steps: StepComparison) -> dict[str, Any]:
    """Of each integrator the runs that reach the end: steps [s], costs [ns per simulated second]
    and errors [m]; and the last two of runs that no other is better than."""
    timed = [
        (run.integrator, run.step, run.ns_per_second or math.inf, run.at(steps.index))
        for run in steps.steps
        if run.cost
    ]
    groups = groupby(timed, lambda point: point[0])
    return {
        "costs": [(of, *list(zip(*points, strict=True))[1:]) for of, points in groups],
        "front": pareto_front([point[2:] for point in timed], lambda point: point),
    }


def mean_ratio(errors: Sequence[float]) -> float:
    """Of each to the one before it, on average."""
    return float((errors[-1] / errors[0]) ** (1 / (len(errors) - 1)))


def _drawn(errors: Array) -> Array:
    return np.where(errors > 0.0, errors, np.nan)
