"""Pose errors of a plan run in an engine: after each manoeuvre, and by kind of manoeuvre."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Reference, Signals
from plumbob.analytic.systems.planner.result import Plan
from plumbob.engines.trajectory import Trajectory

RATE_AT_REST = 1e-12  # [m/s] or [rad/s] largest rate of an exact motion at rest
MAX_PLAN_STEPS = 1_000_000_000  # most steps of a run
STEPS_AFTER_PLAN = 2  # number of steps run after the end of the last manoeuvre
# position of C [m] in the axes of the start; heading [rad]
POSE_OBSERVABLES = ("x", "y", "heading")


def run_duration(plan: Plan, step: float) -> float:
    """Returns the duration [s] that a run of `plan` at `step` [s] needs to show the final pose.
    Raises ParameterError if the step is longer than the plan or more than MAX_PLAN_STEPS times
    shorter."""
    if step > plan.duration:
        raise ParameterError("step", step, f"at most the duration, {plan.duration} s")
    if step * MAX_PLAN_STEPS < plan.duration:
        smallest = plan.duration / MAX_PLAN_STEPS
        raise ParameterError("step", step, f"at least {smallest} s for this duration")
    return (round(plan.duration / step) + STEPS_AFTER_PLAN) * step


def pose_errors(plan: Plan, exact: Reference, run: Trajectory) -> Array:
    """Returns the errors of POSE_OBSERVABLES in a run of `plan` after each manoeuvre, shape
    (manoeuvres, 3); NaN after a manoeuvre whose exact motion is not at rest, or that the run did
    not reach.

    An error is read at the last sample of a manoeuvre. By then the body rests, so that a position
    that lags by half a step makes no error."""
    observed = exact.observe(run.times)
    errors = np.column_stack(
        [run.observables[name] - observed[name] for name in POSE_OBSERVABLES]
    )
    rates = np.abs([observed[name] for name in ("velocity_x", "velocity_y", "heading_rate")])
    at_rest = rates.max(axis=0) <= RATE_AT_REST
    ends = np.append(plan.ends[:-1], np.inf)
    last_samples = np.searchsorted(run.times, ends, side="right") - 1
    reached = run.times[last_samples] > [manoeuvre.start for manoeuvre in plan.manoeuvres]
    known = reached & at_rest[last_samples]
    return np.where(known[:, None], errors[last_samples], np.nan)


def errors_by_kind(plan: Plan, after: Array) -> Signals:
    """Returns the pose error that each kind of manoeuvre added, by kind. `after` are the errors of
    `pose_errors`; NaN means that the body is not at rest after a manoeuvre. A manoeuvre adds the
    error at the next rest minus the error at the rest before. If a manoeuvre leaves the body in
    motion, the errors of the next manoeuvres, up to that rest, are charged to its kind: a turn
    includes its residual motion."""
    total: dict[str, Array] = {}
    before = np.zeros(len(POSE_OBSERVABLES))
    # Kind of the manoeuvre that left the body in motion; empty if the body rests
    left_moving = ""
    for manoeuvre, error in zip(plan.manoeuvres, after, strict=False):
        kind = left_moving or manoeuvre.kind
        if np.isnan(error).any():
            left_moving = kind
            continue
        total[kind] = total.get(kind, np.zeros(len(POSE_OBSERVABLES))) + error - before
        before, left_moving = error, ""
    return total


def error_by_name(error: Array) -> dict[str, float]:
    """Returns a pose error by the names of POSE_OBSERVABLES, and the distance [m] of C from its
    exact position."""
    return {
        "distance": float(np.hypot(*error[:2])),
        **dict(zip(POSE_OBSERVABLES, error.tolist(), strict=True)),
    }
