"""The pose error of a plan run in an engine: after each manoeuvre, and by kind of manoeuvre."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Reference
from plumbob.analytic.systems.planner.result import Plan
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Record
from plumbob.reports.analyses.capsule_plan.plans import plan_numbers, plan_of
from plumbob.reports.analyses.measurements import case

STILL = 1e-12  # [m/s] and [rad/s]: the exact motion is at rest
MOST_STEPS = 1_000_000_000  # of any run
AFTER = 2  # steps run after the last manoeuvre's end


@dataclass(frozen=True)
class PoseError:
    """Error of a pose: of C [m], in the axes of the start, and of the heading [rad]."""

    x: float
    y: float
    heading: float

    @property
    def distance(self) -> float:
        """Distance of C from where it is to be [m]."""
        return float(np.hypot(self.x, self.y))

    def since(self, before: PoseError, so_far: PoseError) -> PoseError:
        """`so_far`, and what has been added since `before`."""
        return PoseError(
            so_far.x + (self.x - before.x),
            so_far.y + (self.y - before.y),
            so_far.heading + (self.heading - before.heading),
        )


PoseErrors = tuple[PoseError | None, ...]
"""After each manoeuvre, in the plan's order; None where the body has not come to rest."""


def run_duration(plan: Plan, step: float) -> float:
    """How long a run of `plan` with `step` [s] has to be to show the pose at its end [s]; raises
    ParameterError for a step longer than the plan or a thousand million times shorter."""
    if step > plan.duration:
        raise ParameterError("step", step, f"at most the duration, {plan.duration} s")
    if step * MOST_STEPS < plan.duration:
        smallest = plan.duration / MOST_STEPS
        raise ParameterError("step", step, f"at least {smallest} s for this duration")
    return (round(plan.duration / step) + AFTER) * step


def pose_errors(plan: Plan, exact: Reference, run: Trajectory) -> PoseErrors:
    """Errors of the pose in a run of `plan` held against its exact motion, after each manoeuvre."""
    seen = exact.observe(run.times)
    error = np.column_stack([run.observables[n] - seen[n] for n in ("x", "y", "heading")])
    names = ("velocity_x", "velocity_y", "heading_rate")
    resting = np.all([np.abs(seen[name]) <= STILL for name in names], axis=0)
    return tuple(_after(plan, run.times, error, resting))


def _after(plan: Plan, times: Array, error: Array, resting: Any) -> list[PoseError | None]:
    """At the last sample of each manoeuvre, at which a place is no longer late by half a step."""
    ends = np.append(plan.ends[:-1], np.inf)
    last = np.searchsorted(times, ends, side="right") - 1
    begun = np.array([manoeuvre.start for manoeuvre in plan.manoeuvres])
    return [
        PoseError(*(float(value) for value in error[k]))
        if resting[k] and times[k] > start
        else None
        for k, start in zip(last, begun, strict=True)
    ]


def by_kind(plan: Plan, after: PoseErrors) -> dict[str, PoseError]:
    """The part that each kind of manoeuvre has added to the pose's error, a turn with its residual
    motion: the error at rest again less the error before."""
    total: dict[str, PoseError] = {}
    before, waiting = PoseError(0.0, 0.0, 0.0), ""
    for manoeuvre, now in zip(plan.manoeuvres, after, strict=False):
        kind = waiting or manoeuvre.kind
        if now is None:
            waiting = kind
            continue
        total[kind] = now.since(before, total.get(kind, PoseError(0.0, 0.0, 0.0)))
        before, waiting = now, ""
    return total


def run_of(name: str, method: str, step: float) -> ExtraRun:
    """A scene's plan run open-loop to its end, with `step` [s]."""
    return ExtraRun(name, method, step, run_duration(plan_of(name), step))


def open_runs(
    study: Study, names: Iterable[str], methods: Iterable[str], step: float
) -> tuple[Record, ...]:
    """The plans of scenes that methods ran with `step` [s], but those that do not reach an end."""
    every = (_open_run(study, run_of(n, m, step)) for n, m in product(names, methods))
    return tuple(filter(None, every))


def _open_run(study: Study, request: ExtraRun) -> Record | None:
    """A plan run open-loop to its end: the errors after manoeuvres at whose end the body is at
    rest, and what each kind of manoeuvre added."""
    name, plan = request.scene, plan_of(request.scene)
    if (recorded := study.answer(request)) is None or len(recorded.times) < 2:
        return None
    errors = pose_errors(plan, case(name).reference, recorded)
    after = [
        Record(
            time=end,  # [s]
            kind=manoeuvre.kind,
            error=error,
        )
        for end, manoeuvre, error in zip(plan.ends, plan.manoeuvres, errors, strict=True)
        if error is not None
    ]
    if errors[-1] is None:
        return None
    return Record(
        scene=name,
        plan=plan_numbers(plan),
        method=request.method,
        after=after,
        parts=by_kind(plan, errors),
        end=errors[-1],
    )
