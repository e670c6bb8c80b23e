"""The poses that plans reach."""

from __future__ import annotations

from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_plan.plans import (
    capsule_plan_of,
    plan_numbers,
    planned_scenes,
)


def numbers(study: Study) -> Record | None:
    """Returns the numbers of each plan in the study, by scene; None if there is no plan."""
    plans = {name: plan_numbers(capsule_plan_of(name)) for name in planned_scenes(study)}
    if not plans:
        return None
    # [m] or [rad] largest pose error of an exact motion
    worst = max(max(plan.distance, plan.angle) for plan in plans.values())
    return Record(plans=plans, profile=study.profile, worst=worst)


GOAL_POSES_FINDING = Analysis("capsule_plan/poses", numbers)
