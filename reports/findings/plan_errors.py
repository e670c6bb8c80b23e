"""What an engine makes of a plan: how far off the pose is at its end, and where that arises."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.planner import Plan
from plumbob.engines.adapters.sampling import step_count
from plumbob.engines.method import Method
from plumbob.engines.study.measurement import Measurement, measure
from plumbob.models.registry import system_of
from plumbob.models.scene import Scene

STILL = 1e-12  # [m/s] and [rad/s]: the exact motion is at rest
AFTER = 2  # steps run after the last manoeuvre's end


@dataclass(frozen=True)
class PoseOff:
    """By how much a pose is off: of C [m], in the axes of the start, and of the heading [rad]."""

    x: float
    y: float
    heading: float

    @property
    def distance(self) -> float:
        """How far C is off [m]."""
        return float(np.hypot(self.x, self.y))

    def since(self, before: PoseOff) -> PoseOff:
        """What has come to it since `before`."""
        return PoseOff(self.x - before.x, self.y - before.y, self.heading - before.heading)


@dataclass(frozen=True)
class PlanRun:
    """A plan run open-loop, held against its exact motion; after each manoeuvre, in the order of
    the plan, by how much the pose is off, or None where the body has not come to rest."""

    found: Measurement
    after: tuple[PoseOff | None, ...]


def run_plan(plan: Plan, scene: Scene, method: Method, step: float) -> PlanRun:
    """Run `plan`, which is that of `scene`, with `step` [s] to its end. Raises ParameterError."""
    lasting = (step_count(plan.duration, step) + AFTER) * step
    system = system_of(scene)
    whole = replace(scene, duration=lasting)
    case = system.case(whole)
    exact = case.reference
    found, run = measure(case, method, step)
    if run is None or found.status != "done":
        return PlanRun(found, ())
    seen = exact.observe(run.times)
    off = np.column_stack([run.observables[n] - seen[n] for n in ("x", "y", "heading")])
    names = ("velocity_x", "velocity_y", "heading_rate")
    resting = np.all([np.abs(seen[name]) <= STILL for name in names], axis=0)
    return PlanRun(found, tuple(_after(plan, run.times, off, resting)))


def _after(plan: Plan, times: Array, off: Array, resting: Array) -> list[PoseOff | None]:
    """At the last sample of each manoeuvre, at which a place no longer lags by half a step."""
    ends = np.append(plan.ends[:-1], np.inf)
    last = np.searchsorted(times, ends, side="right") - 1
    begun = np.array([manoeuvre.start for manoeuvre in plan.manoeuvres])
    return [
        PoseOff(*(float(value) for value in off[k])) if resting[k] and times[k] > start else None
        for k, start in zip(last, begun, strict=True)
    ]


def arising(plan: Plan, run: PlanRun) -> dict[str, PoseOff]:
    """What each kind of manoeuvre has added to the pose's error, a turn with its residual motion:
    what is off at rest again less what was off before."""
    total: dict[str, PoseOff] = {}
    before, waiting = PoseOff(0.0, 0.0, 0.0), ""
    for manoeuvre, now in zip(plan.manoeuvres, run.after, strict=False):
        kind = waiting or manoeuvre.kind
        if now is None:
            waiting = kind
            continue
        so_far, gained = total.get(kind, PoseOff(0.0, 0.0, 0.0)), now.since(before)
        total[kind] = PoseOff(
            so_far.x + gained.x, so_far.y + gained.y, so_far.heading + gained.heading
        )
        before, waiting = now, ""
    return total
