"""Numbers that the template of a motion audit needs beside the audit itself."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.reference import RESOLVED
from plumbob.engines.audit.step_errors import TARGETS, Compared, horizon
from plumbob.engines.own_motion import OUT_OF_TIME
from plumbob.reports.advice.work_precision import front

SHOWN = 5  # largest number of errors listed as the step is halved
COURSES = 4  # number of steps of the model's integrator in the figure over time


def motion_of(audit: Audit) -> dict[str, Any]:
    """Returns the numbers of the template; empty if no motion was certified.

    - `runs`: the runs of the model's integrator at the model's step and at its halves
    - `errors`: the error [m] of each run at the end of the last period in which the steps converge
    - `resolved`: the errors above `known` [m], the level set by the uncertainty of the reference
    - `ratio`: the mean ratio of one resolved error to the next
    - `holds`: the largest step [s] whose error stays finite to the end
    - `diverged`: whether the error of the model's step does not
    - `horizons`: errors [m], each with the time [s] up to which the most accurate step stays within
      it (None: to the end)
    - `event_rate`: rate at which contacts and limits begin or cease to act [1/s]
    - `courses`, `uncertainty`: errors and uncertainty [m] over time, for a figure
    - the entries of `_choices` and `_costs`"""
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


def _choices(audit: Audit, steps: Compared) -> dict[str, Any]:
    """Returns two choices: `better`, the cheapest step and integrator for an error below the error
    of the model's step; and `enough`, the cheapest one for the smallest target error that is no
    smaller than the error of the model's step. Each is None if there is none; `enough` also if the
    audit is not complete or nothing is saved."""
    least = audit.error + audit.uncertainty
    better = (choice for choice in steps.cheapest if choice.target < audit.error)
    enough = [choice for choice in steps.cheapest if choice.target >= least][-1:]
    saving = (c for c in enough if c.cost is not None and c.cost.saves and audit.complete)
    return {"better": next(better, None), "enough": next(saving, None)}


def _costs(steps: Compared) -> dict[str, Any]:
    """Returns `costs`: for each integrator the steps [s], the costs [ns per simulated second] and
    the errors [m] of its timed runs; and `front`: the costs and errors of the Pareto front."""
    timed = [
        (run.integrator, run.step, run.ns_per_second or math.inf, run.at(steps.index))
        for run in steps.steps
        if run.cost
    ]
    groups = groupby(timed, lambda point: point[0])
    return {
        "costs": [(of, *list(zip(*points, strict=True))[1:]) for of, points in groups],
        "front": front([point[2:] for point in timed], lambda point: point),
    }


def mean_ratio(errors: Sequence[float]) -> float:
    """Returns the geometric mean of the ratios of each error to the error before it."""
    return float((errors[-1] / errors[0]) ** (1 / (len(errors) - 1)))


def _drawn(errors: Array) -> Array:
    return np.where(errors > 0.0, errors, np.nan)
