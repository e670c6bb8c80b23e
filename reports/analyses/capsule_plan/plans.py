"""The plans of a study, each in a few numbers."""

from __future__ import annotations

from dataclasses import dataclass

from plumbob.analytic.systems.planner.result import Plan
from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene, scenes
from plumbob.models.tripod_capsule.plan import planned

SYSTEM = "capsule-plan"
SHOWN = "capsule-plan/near-free"  # drawn where the study has it


@dataclass(frozen=True)
class PlanNumbers:
    """Where a plan goes, along which curve, how long it takes, and its exact motion's error."""

    x: float  # [m], of the goal
    y: float
    heading: float  # [rad]
    track: str
    legs: tuple[int, int]
    arc: str
    duration: float  # [s]
    turns: int
    lines: int
    manoeuvres: int  # of any kind
    distance: float  # [m], from the goal
    angle: float  # [rad]


def plan_of(name: str) -> Plan:
    """The plan of a scene."""
    return planned(scene(name).parameters)


def names(study: Study | StudyPlan) -> tuple[str, ...]:
    """The scenes of a study that have a plan."""
    covered = {scene.name for scene in study.scenes}
    return tuple(scene.name for scene in scenes(SYSTEM) if scene.name in covered)


def plan_numbers(plan: Plan) -> PlanNumbers:
    """A plan in numbers."""
    goal = plan.goal
    return PlanNumbers(
        goal.x,
        goal.y,
        goal.heading,
        plan.track,
        plan.legs,
        plan.arc,
        plan.duration,
        plan.turns,
        plan.lines,
        len(plan.manoeuvres),
        *plan.error,
    )
