"""Errors of the body angle that the findings on turns use, at 2 tau and at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Literal

import numpy as np

from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.analyses.measurements import measured, plan_of, problem

When = Literal["stop", "rest"]
WHENS: tuple[When, When] = ("stop", "rest")
METHODS = ("mujoco/euler", "mujoco/euler+coulomb", "mujoco/rk4+coulomb", "pymunk/feet")
JUDGED = 800  # steps in a half time at which the accuracy asked for is judged
QUICK = (0.3, 0.03)  # the turns of the quick profile


def name_of(epsilon: float, when: When = "rest") -> str:
    """The scene of a turn until all is at rest, or until 2 tau."""
    return f"capsule-turn/{epsilon}" + ("-stop" if when == "stop" else "")


@cache
def turn(epsilon: float) -> TurnManoeuvre:
    """The check manoeuvre with tau = epsilon T."""
    manoeuvre = problem(name_of(epsilon)).motion.manoeuvre
    assert isinstance(manoeuvre, TurnManoeuvre)
    return manoeuvre


@cache
def facts(epsilon: float) -> Mapping[str, float]:
    """Angles of the exact motion and of the formulas."""
    scene = find_scene(name_of(epsilon))
    return system_of(scene).facts(problem(scene.name))


def epsilons(study: Study | StudyPlan) -> tuple[float, ...]:
    """The turns that a profile looks at, large epsilon first."""
    return EPSILONS if study.profile == "full" else QUICK


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Each turn with each method at the step judged, unless the study measures it at 2 tau and at
    rest itself."""
    return [
        judged_run(epsilon, method)
        for epsilon in epsilons(plan)
        for method in METHODS
        if not _measured_by(plan, epsilon, method)
    ]


def judged_run(epsilon: float, method: str) -> ExtraRun:
    """A turn until it rests, at the step judged."""
    return ExtraRun(name_of(epsilon), method, turn(epsilon).half_time / JUDGED)


def _measured_by(plan: StudyPlan, epsilon: float, method: str) -> bool:
    """Whether a study runs a turn both until 2 tau and until it rests."""
    return all(plan.has(name_of(epsilon, when), method) for when in WHENS)


def judged_error(study: Study, epsilon: float, method: str, when: When) -> float | None:
    """The error of the body angle [rad] at 2 tau or at rest, at the step judged, from the recorded
    run where the study has no measurement; None where neither is."""
    if run := measured(study, name_of(epsilon, when), method, turn(epsilon).half_time / JUDGED):
        return run.errors["body_angle"].end
    if _measured_by(plan_of(study), epsilon, method):
        return None
    if (recording := study.answer(judged_run(epsilon, method))) is None:
        return None
    stop = 2.0 * turn(epsilon).half_time
    at = int(np.argmin(np.abs(recording.times - stop))) if when == "stop" else -1
    exact = facts(epsilon)["body_angle" if when == "stop" else "body_angle_at_rest"]
    return float(recording.observables["body_angle"][at]) - exact
