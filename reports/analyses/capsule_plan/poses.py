"""Poses that plans reach, beside plans of equal manoeuvres to the same poses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from plumbob.analytic.systems.planner.construction import plan as find_plan
from plumbob.analytic.systems.planner.result import Plan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.capsule_plan.plans import PlanNumbers, names, plan_numbers, plan_of


@dataclass(frozen=True)
class Pair:
    """A scene's plan beside the naive one."""

    scene: str
    best: PlanNumbers
    naive: PlanNumbers

    @property
    def factor(self) -> float:
        """How many times as long the naive plan takes."""
        return self.naive.duration / self.best.duration


@dataclass(frozen=True)
class Poses:
    """All plans of a study."""

    plans: tuple[Pair, ...]
    profile: str

    @property
    def worst(self) -> float:
        """The largest error of an exact motion [m] or [rad]."""
        return max(max(plan.best.distance, plan.best.angle) for plan in self.plans)

    @property
    def least_factor(self) -> float:
        """Of a naive plan's time over the best one's."""
        return min(plan.factor for plan in self.plans)

    @property
    def largest_factor(self) -> float:
        """The same, of the slowest."""
        return max(plan.factor for plan in self.plans)


@cache
def naive(name: str) -> Plan:
    """The plan of equal manoeuvres for the same pose, under the same limits."""
    best = plan_of(name)
    return find_plan(
        best.capsule,
        best.goal,
        best.limits,
        best.track,
        best.start,
        equal=True,
        legs=best.legs,
        arc=best.arc,
    )


def numbers(study: Study) -> Poses | None:
    """Each plan that the study has, beside the naive one; None without any."""
    plans = tuple(
        Pair(name, plan_numbers(plan_of(name)), plan_numbers(naive(name))) for name in names(study)
    )
    return Poses(plans, study.profile) if plans else None


POSES = Analysis("capsule_plan/poses", numbers)
