"""The poses that plans reach."""

from __future__ import annotations

from plumbob.models.registry import matching_scenes
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_plan.plans import (
    SYSTEM,
    capsule_plan_of,
    plan_numbers,
)


def numbers() -> Record:
    """Returns the numbers of the plan of each scene with a plan, by scene, and the largest pose
    error."""
    names = [scene.name for scene in matching_scenes(SYSTEM)]
    plans = {name: plan_numbers(capsule_plan_of(name)) for name in names}
    # [m] or [rad] largest pose error of an exact motion
    worst = max(max(plan.distance, plan.angle) for plan in plans.values())
    return Record(plans=plans, worst=worst)


GOAL_POSES_FINDING = Analysis("capsule_plan/poses", exact=numbers)
