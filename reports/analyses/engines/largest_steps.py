"""The largest steps at which methods hold on smooth motions, measured beside their prediction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from plumbob.engines.method import meant
from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.request import Request
from plumbob.engines.study.results import Study
from plumbob.engines.study.stability import StabilitySearch, StepPrediction
from plumbob.models.registry import system_of
from plumbob.models.scene import ON_SUPPORTS
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.claims import as_expected
from plumbob.reports.judge.stability import study_limits
from plumbob.reports.view.step_ranges import SCENES

# In the quick profile: an equilibrium with each scheme of each engine, and a swing with one of each
# engine.
EQUILIBRIUM, SWING = "linear-pendulum/overdamped", "simple-pendulum/free-large"
OF_SWING = ("mujoco/euler", "ode/leapfrog", "pymunk/default")


@dataclass(frozen=True)
class LargestSteps:
    """The limits, a record each as `plumbob stability --json` prints them, and why those that are
    unexpected are."""

    limits: tuple[Mapping[str, Any], ...]
    surprises: tuple[str, ...]

    @property
    def predicted(self) -> int:
        """Limits that theory predicts."""
        return sum(limit["verdict"] == "predicted" for limit in self.limits)

    @property
    def known(self) -> int:
        """Known limits, which it does not."""
        return sum(bool(limit["known_limit"]) for limit in self.limits)


def searches(plan: StudyPlan) -> Sequence[StabilitySearch]:
    """In the full profile every method that is given a step, on each smooth scene of the quick
    one."""
    quick = plan.profile == "quick"
    by_scheme = {
        (scene.name, method.engine, method.scheme if quick else method.name): method.name
        for scene in reversed(plan.scenes)
        for method in reversed(plan.methods)
        if scene.profile == "quick" and scene.kind != ON_SUPPORTS
        if method.control == "step" and plan.has(scene.name, method.name)
        if not quick
        or scene.name == EQUILIBRIUM
        or (scene.name == SWING and method.name in OF_SWING)
    }
    searched = reversed(by_scheme.items())  # of equal ones the first
    return tuple(StabilitySearch(scene, method) for (scene, *_), method in searched)


def predictions(plan: StudyPlan) -> Sequence[StepPrediction]:
    """Of the pairs of the plan whose system has a theory of the largest step; in the quick profile
    of the first screen's scenes alone, since all of them take half a minute."""
    return tuple(
        StepPrediction(scene.name, method.name)
        for scene in plan.scenes
        for method in plan.methods
        if system_of(scene).stability and meant(method, scene)
        if plan.profile != "quick" or scene.name in SCENES
    )


def requests(plan: StudyPlan) -> Sequence[Request[Any]]:
    """Searches and predictions of limits."""
    return (*searches(plan), *predictions(plan))


def numbers(study: Study) -> LargestSteps | None:
    """The limits that the study holds; None where it holds none."""
    judged = [limit for limit in study_limits(study) if limit.limit is not None]
    if not judged:
        return None
    surprises = [f"{of.scene} {of.method}: {of.surprise}" for of in judged if of.surprise]
    return LargestSteps(tuple(limit.record() for limit in judged), tuple(surprises))


LARGEST_STEPS = Analysis(
    "engines/largest_steps", numbers, requests, lambda found: as_expected(found.surprises)
)
