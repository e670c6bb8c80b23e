"""The plans of a study, each in a few numbers."""

from __future__ import annotations

from plumbob.analytic.systems.planner.result import Plan
from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene, scenes
from plumbob.models.tripod_capsule.plan import requested_plan
from plumbob.reports.analyses.analysis import Record

SYSTEM = "capsule-plan"


def plan_of(name: str) -> Plan:
    """The plan of a scene."""
    return requested_plan(scene(name).parameters)


def names(study: Study | StudyPlan) -> tuple[str, ...]:
    """The scenes of a study that have a plan."""
    covered = {scene.name for scene in study.scenes}
    return tuple(scene.name for scene in scenes(SYSTEM) if scene.name in covered)


def plan_numbers(plan: Plan) -> Record:
    """Where a plan goes, along which curve, how long it takes, and its exact motion's error."""
    distance, angle = plan.error
    return Record(
        x=plan.goal.x,  # [m]
        y=plan.goal.y,
        heading=plan.goal.heading,  # [rad]
        track=plan.track,
        legs=plan.legs,
        arc=plan.arc,
        segments=plan.segments,
        duration=plan.duration,  # [s]
        turns=plan.turns,
        lines=plan.lines,
        manoeuvres=len(plan.manoeuvres),  # of any kind
        distance=distance,  # [m], from the goal
        angle=angle,  # [rad]
    )
