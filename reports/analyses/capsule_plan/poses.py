"""The poses that plans reach."""

from __future__ import annotations

from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_plan.plans import plan_numbers, plan_of, planned_scenes


def numbers(study: Study) -> Record | None:
    """Returns the numbers of each plan in the study, by scene; None if there is no plan."""
    plans = {name: plan_numbers(plan_of(name)) for name in planned_scenes(study)}
    if not plans:
        return None
    # [m] or [rad] largest pose error of an exact motion
    worst = max(max(plan.distance, plan.angle) for plan in plans.values())
    return Record(plans=plans, profile=study.profile, worst=worst)


POSES = Analysis("capsule_plan/poses", numbers)
