"""The largest stable steps of methods on smooth motions, measured and predicted."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from plumbob.analytic.errors.stability.adaptive_cost import stiffness_cost
from plumbob.analytic.tableau import order_8
from plumbob.engines.method import meant
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.request import Request
from plumbob.engines.study.results import Study
from plumbob.engines.study.stability import StabilitySearch
from plumbob.models.registry import case_of, stability_of, system_of
from plumbob.models.scene import ON_SUPPORTS, SMOOTH
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import as_expected, at_most
from plumbob.reports.analyses.measurements import plan_of
from plumbob.reports.judge.stability import study_limits
from plumbob.reports.view.content import Claim
from plumbob.reports.view.site.largest_step import SCENES

# scenes searched in the quick profile: the equilibrium with each scheme of each engine, the swing
# with one method of each engine
EQUILIBRIUM, SWING = "linear-pendulum/overdamped", "simple-pendulum/free-large"
OF_SWING = ("mujoco/euler", "ode/leapfrog", "pymunk/default")
SOLVERS = ("ode/dop853", "ode/radau", "ode/lsoda")  # solvers with a variable step
DAMPING = (1e1, 1e2, 1e3, 1e4)  # [1/s] damping rates, in place of the scene's
LONG = 3e3  # approximate length of these runs, in time constants of the fastest mode
TOLERANCE = 1e-3  # largest tolerance, so that stability alone limits the step
ALIKE = 0.2  # largest relative difference of measured and predicted evaluations
EVALUATIONS = 12  # evaluations of the equation of motion in a step of DOP853


def searches(plan: StudyPlan) -> Sequence[StabilitySearch]:
    """Returns the searches for largest stable steps.

    In the full profile, they are of every method with a fixed step on each smooth scene of the
    quick profile. In the quick profile, they are of one method for each scheme and engine on the
    equilibrium, and of three methods on the swing. Scenes with several degrees of freedom take
    minutes and are left to `plumbob stability`."""
    quick = plan.profile == "quick"
    by_scheme = {
        (scene.name, method.engine, method.scheme if quick else method.name): method.name
        for scene in reversed(plan.scenes)
        for method in reversed(plan.methods)
        if scene.profile == "quick" and scene.kind not in (ON_SUPPORTS, SMOOTH)
        if method.control == "step" and plan.has(scene.name, method.name)
        if not quick
        or scene.name == EQUILIBRIUM
        or (scene.name == SWING and method.name in OF_SWING)
    }
    searched = reversed(by_scheme.items())  # the first method of each scheme
    return tuple(StabilitySearch(scene, method) for (scene, *_), method in searched)


def predictions(plan: StudyPlan) -> Sequence[StabilitySearch]:
    """Returns the predictions of largest stable steps, without runs, for all pairs of scene and
    method that are not searched and whose system has a theory of stability.

    The quick profile predicts only the scenes of the first screen, since all scenes together take
    half a minute."""
    searched = {(search.scene, search.method) for search in searches(plan)}
    return tuple(
        StabilitySearch(scene.name, method.name, by_runs=False)
        for scene in plan.scenes
        for method in plan.methods
        if system_of(scene).stability and scene.kind != SMOOTH and meant(method, scene)
        if plan.profile != "quick" or scene.name in SCENES
        if (scene.name, method.name) not in searched
    )


def solver_runs(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Returns the runs of solvers with a variable step on the equilibrium at several damping
    rates."""
    return tuple(
        ExtraRun(
            EQUILIBRIUM,
            solver,
            TOLERANCE,
            LONG / damping,
            (("damping_rate", damping),),
            end_alone=True,
        )
        for damping in DAMPING
        for solver in SOLVERS
        if plan.has(EQUILIBRIUM, solver)
    )


def requests(plan: StudyPlan) -> Sequence[Request[Any]]:
    """Returns the searches, the predictions and the runs of solvers with a variable step."""
    return (*searches(plan), *predictions(plan), *solver_runs(plan))


def paid(study: Study) -> Mapping[float, Mapping[str, float]]:
    """Returns the cost of stiffness for solvers with a variable step, by damping rate [1/s] and
    solver: evaluations per simulated second [1/s]. The entry "predicted" is the number that
    stability requires of the first solver."""
    rates: dict[float, dict[str, float]] = {}
    for request in solver_runs(plan_of(study)):
        theory = stability_of(case_of(request.posed()))
        assert theory is not None
        fastest = np.array([-math.tau / theory.fastest + 0j])
        predicted = EVALUATIONS * float(stiffness_cost(order_8(), fastest))
        of = rates.setdefault(dict(request.changes)["damping_rate"], {"predicted": predicted})
        if run := study.answer(request):
            of[request.method] = run.steps / float(run.times[-1])
    return rates


def numbers(study: Study) -> Record | None:
    """Returns the largest stable steps that the study holds; None if it holds none."""
    judged = [limit for limit in study_limits(study) if limit.limit is not None]
    if not judged:
        return None
    surprises = [f"{of.scene} {of.method}: {of.surprise}" for of in judged if of.surprise]
    records = [limit.record() for limit in judged]
    return Record(
        limits=records,
        surprises=surprises,
        paid=paid(study),
        predicted=sum(limit["verdict"] == "predicted" for limit in records),
        known=sum(bool(limit["known_limit"]) for limit in records),
    )


def claims(numbers: Record) -> Sequence[Claim]:
    """Returns the checks that no limit is unexpected, and that the first solver needs the
    evaluations that stability requires."""
    pays = (
        at_most(
            f"what DOP853 pays at {damping:g}/s beside what is predicted, less 1,",
            of[SOLVERS[0]] / of["predicted"] - 1.0,
            ALIKE,
        )
        for damping, of in numbers.paid.items()
        if SOLVERS[0] in of
    )
    return (*as_expected(numbers.surprises), *pays)


LARGEST_STEPS = Analysis("engines/largest_steps", numbers, requests, claims)
