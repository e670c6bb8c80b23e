"""The pose error of a plan run in an engine: after each manoeuvre, and by kind of manoeuvre."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Reference, Signals
from plumbob.analytic.systems.planner.result import Plan
from plumbob.engines.trajectory import Trajectory

STILL = 1e-12  # [m/s] and [rad/s]: the exact motion is at rest
MOST_STEPS = 1_000_000_000  # of any run
AFTER = 2  # steps run after the last manoeuvre's end
POSE = ("x", "y", "heading")  # of C [m], in the axes of the start, and of the body [rad]


def run_duration(plan: Plan, step: float) -> float:
    """How long a run of `plan` with `step` [s] has to be to show the pose at its end [s]; raises
    ParameterError for a step longer than the plan or a thousand million times shorter."""
    if step > plan.duration:
        raise ParameterError("step", step, f"at most the duration, {plan.duration} s")
    if step * MOST_STEPS < plan.duration:
        smallest = plan.duration / MOST_STEPS
        raise ParameterError("step", step, f"at least {smallest} s for this duration")
    return (round(plan.duration / step) + AFTER) * step


def pose_errors(plan: Plan, exact: Reference, run: Trajectory) -> Array:
    """Errors of POSE in a run of `plan` held against its exact motion, after each manoeuvre, shape
    (manoeuvres, 3): at the last sample, at which a place is no longer late by half a step; NaN
    where the body has not come to rest."""
    seen = exact.observe(run.times)
    error = np.column_stack([run.observables[name] - seen[name] for name in POSE])
    rates = np.abs([seen[name] for name in ("velocity_x", "velocity_y", "heading_rate")])
    ends = np.append(plan.ends[:-1], np.inf)
    last = np.searchsorted(run.times, ends, side="right") - 1
    begun = run.times[last] > [manoeuvre.start for manoeuvre in plan.manoeuvres]
    resting = begun & (rates.max(axis=0) <= STILL)[last]
    return np.where(resting[:, None], error[last], np.nan)


def by_kind(plan: Plan, after: Array) -> Signals:
    """The part that each kind of manoeuvre has added to the pose's error, a turn with its residual
    motion: the error at rest again less the error before; nothing where nothing ran."""
    total: dict[str, Array] = {}
    before = np.zeros(len(POSE))
    waiting = ""
    for manoeuvre, now in zip(plan.manoeuvres, after, strict=False):
        kind = waiting or manoeuvre.kind
        if np.isnan(now).any():
            waiting = kind
            continue
        total[kind] = total.get(kind, np.zeros(len(POSE))) + now - before
        before, waiting = now, ""
    return total


def named(error: Array) -> dict[str, float]:
    """An error of POSE by name, and the distance of C from where it is to be [m]."""
    return {
        "distance": float(np.hypot(*error[:2])),
        **dict(zip(POSE, error.tolist(), strict=True)),
    }
