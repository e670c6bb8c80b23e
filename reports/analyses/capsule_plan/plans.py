"""The plans of a study and their main numbers."""

from __future__ import annotations

from plumbob.analytic.systems.planner.result import Plan
from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene, scenes
from plumbob.models.tripod_capsule.plan import requested_plan
from plumbob.reports.analyses.analysis import Record

SYSTEM = "capsule-plan"


def plan_of(name: str) -> Plan:
    """Returns the plan of a scene, by the scene's name."""
    return requested_plan(scene(name).parameters)


def planned_scenes(study: Study | StudyPlan) -> tuple[str, ...]:
    """Returns the names of the study's scenes that have a plan."""
    covered = {scene.name for scene in study.scenes}
    return tuple(scene.name for scene in scenes(SYSTEM) if scene.name in covered)


def plan_numbers(plan: Plan) -> Record:
    """Returns the main numbers of a plan: its goal, track, duration, manoeuvres, and the final pose
    error of its exact motion."""
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
        manoeuvres=len(plan.manoeuvres),  # number of manoeuvres of any kind
        distance=distance,  # [m] distance from the goal at the end
        angle=angle,  # [rad] difference from the goal's heading at the end
    )
