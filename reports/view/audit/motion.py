"""Numbers that the template of a motion audit needs beside the audit itself."""

from __future__ import annotations

import math
from itertools import groupby
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.mean_returns import EpisodeReturns
from plumbob.engines.audit.step_errors import TARGETS, StepComparison, horizon
from plumbob.reports.advice.work_precision import pareto_front

DRAWN_EPISODES = 50  # number of episodes whose returns are drawn as dots
DRAWN_STEPS = 4  # number of steps of the model's integrator in the figure over time


def motion_numbers(audit: Audit) -> dict[str, Any]:
    """Returns the numbers of the template; empty if no motion was certified.

    - `horizons`: errors [m], each with the time [s] up to which the most accurate step stays within
      it (None: to the end)
    - `event_rate`: rate at which contacts and limits begin or cease to act [1/s]
    - `courses`, `uncertainty`: errors and uncertainty [m] over time, for a figure
    - `returned`: the entries of `_returned`
    - the entries of `_costs`"""
    returned = _returned(audit.returns) if audit.returns is not None else ()
    if audit.found is None:
        return {"returned": returned}
    compared = audit.found
    reference = audit.reference
    horizons = []
    for target in TARGETS[1:3]:
        end = horizon(compared, reference, audit.script, target)
        horizons.append((target, None if math.isinf(end) else end))
    course = reference.course
    return {
        "horizons": horizons,
        "event_rate": len(course.events) / max(course.until, audit.script.period),
        "courses": [
            (run.integrator, run.step, _drawn(run.errors))
            for run in compared.own_and_finer[:DRAWN_STEPS]
        ],
        "uncertainty": _drawn(reference.uncertainty),
        "returned": returned,
        **_costs(compared),
    }


def _returned(returns: EpisodeReturns) -> list[dict[str, Any]]:
    """Returns for each integrator its `steps` [s], by how much the mean return at each step differs
    from the mean return at the model's own step (`changes`), the ends of its interval (`low`,
    `high`), and `dots`: a step and a difference for each of the first DRAWN_EPISODES episodes."""
    drawn = []
    columns = list(enumerate(returns.rows))
    for integrator, group in groupby(columns, lambda column: column[1].integrator):
        rows = list(group)
        dots = [
            (row.step, float(value))
            for number, row in rows
            for value in (returns.values[:, number] - returns.values[:, 0])[:DRAWN_EPISODES]
            if np.isfinite(value)
        ]
        changes = [row.difference for _, row in rows]
        drawn.append(
            {
                "integrator": integrator,
                "steps": [row.step for _, row in rows],
                "changes": [change.mean if change else 0.0 for change in changes],
                "low": [change.low if change else 0.0 for change in changes],
                "high": [change.high if change else 0.0 for change in changes],
                "dots": dots,
            }
        )
    return drawn


def _costs(compared: StepComparison) -> dict[str, Any]:
    """Returns `costs`: for each integrator the steps [s], the costs [ms per simulated second] and
    the errors [m] of its timed runs; and `front`: the costs and errors of the Pareto front."""
    timed = [run for run in compared.steps if run.cost]
    costs = []
    points = list[tuple[float, float]]()
    for integrator, group in groupby(timed, lambda run: run.integrator):
        runs = list(group)
        ms_per_second = [1e-6 * (run.ns_per_second or math.inf) for run in runs]
        errors = [run.at(compared.index) for run in runs]
        costs.append((integrator, tuple(run.step for run in runs), ms_per_second, errors))
        points += zip(ms_per_second, errors, strict=True)
    return {"costs": costs, "front": pareto_front(points, lambda point: point)}


def _drawn(errors: Array) -> Array:
    """Returns errors for a logarithmic axis: NaN, a gap, for each that is not positive."""
    return np.where(errors > 0.0, errors, np.nan)
