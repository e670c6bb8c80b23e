"""The largest stable steps of methods on smooth motions, measured and predicted."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np

from plumbob.analytic.errors.stability.adaptive_cost import stiffness_cost
from plumbob.analytic.tableau import order_8
from plumbob.engines.method import Method, meant
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.request import Request
from plumbob.engines.study.results import Study
from plumbob.engines.study.stability import StabilitySearch
from plumbob.models.registry import case_of, stability_of, system_of
from plumbob.models.scene import ON_SUPPORTS, SMOOTH, Scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import as_expected, at_most
from plumbob.reports.analyses.measurements import study_plan
from plumbob.reports.judge.stability import study_limits
from plumbob.reports.records.claim import Claim
from plumbob.reports.records.page_records import LIMITED_SCENES

# scenes searched in the quick profile: the equilibrium with each scheme of each engine, the swing
# with one method of each engine
EQUILIBRIUM, SEARCHED_SWING = "linear-pendulum/overdamped", "simple-pendulum/free-large"
OF_SWING = ("mujoco/euler", "ode/leapfrog", "pymunk/default")
VARIABLE_STEP_SOLVERS = ("ode/dop853", "ode/radau", "ode/lsoda")  # solvers with a variable step
DAMPING_RATES = (1e1, 1e2, 1e3, 1e4)  # [1/s] damping rates, in place of the scene's
# approximate length of these runs, in time constants of the fastest mode
RUN_TIME_CONSTANTS = 3e3
LARGEST_TOLERANCE = 1e-3  # largest tolerance, so that stability alone limits the step
EVALUATIONS_TOLERANCE = 0.2  # largest relative difference of measured and predicted evaluations
DOP853_EVALUATIONS = 12  # evaluations of the equation of motion in a step of DOP853


def searches(plan: StudyPlan) -> Sequence[StabilitySearch]:
    """Returns the searches for largest stable steps.

    In the full profile, they are of every method with a fixed step on each smooth scene of the
    quick profile. In the quick profile, they are of one method for each scheme and engine on the
    equilibrium, and of three methods on the swing. Scenes with several degrees of freedom take
    minutes and are left to `plumbob stability`."""
    quick = plan.profile == "quick"
    seen = set[tuple[Any, ...]]()  # in the quick profile: one method for each scheme and engine
    requested = list[StabilitySearch]()
    for scene, method in product(plan.scenes, plan.methods):
        if not _is_searched(plan, scene, method):
            continue
        key = (scene.name, method.engine, method.scheme if quick else method.name)
        if key not in seen:
            seen.add(key)
            requested.append(StabilitySearch(scene.name, method.name))
    return tuple(requested)


def _is_searched(plan: StudyPlan, scene: Scene, method: Method) -> bool:
    """Returns whether the largest stable step of a method on a scene is searched by runs."""
    if scene.profile != "quick" or scene.kind in (ON_SUPPORTS, SMOOTH):
        return False
    if method.control != "step" or not plan.has(scene.name, method.name):
        return False
    if plan.profile != "quick" or scene.name == EQUILIBRIUM:
        return True
    return scene.name == SEARCHED_SWING and method.name in OF_SWING


def predictions(plan: StudyPlan) -> Sequence[StabilitySearch]:
    """Returns the predictions of largest stable steps, without runs, for all pairs of scene and
    method that are not searched and whose system has a theory of stability.

    The quick profile predicts only the scenes of the first screen, since all scenes together take
    half a minute."""
    searched = {(search.scene, search.method) for search in searches(plan)}
    scenes = [
        scene
        for scene in plan.scenes
        if system_of(scene).stability and scene.kind != SMOOTH
        if plan.profile != "quick" or scene.name in LIMITED_SCENES
    ]
    return tuple(
        StabilitySearch(scene.name, method.name, by_runs=False)
        for scene, method in product(scenes, plan.methods)
        if meant(method, scene) and (scene.name, method.name) not in searched
    )


def solver_runs(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Returns the runs of solvers with a variable step on the equilibrium at several damping
    rates."""
    solvers = [solver for solver in VARIABLE_STEP_SOLVERS if plan.has(EQUILIBRIUM, solver)]
    return tuple(
        ExtraRun(
            scene=EQUILIBRIUM,
            method=solver,
            step=LARGEST_TOLERANCE,
            duration=RUN_TIME_CONSTANTS / damping,
            changes=(("damping_rate", damping),),
            end_alone=True,
        )
        for damping, solver in product(DAMPING_RATES, solvers)
    )


def requests(plan: StudyPlan) -> Sequence[Request[Any]]:
    """Returns the searches, the predictions and the runs of solvers with a variable step."""
    return (*searches(plan), *predictions(plan), *solver_runs(plan))


def evaluation_rates(study: Study) -> Mapping[float, Mapping[str, float]]:
    """Returns the cost of stiffness for solvers with a variable step, by damping rate [1/s] and
    solver: evaluations per simulated second [1/s]. The entry "predicted" is the number that
    stability requires of the first solver."""
    rates: dict[float, dict[str, float]] = {}
    for request in solver_runs(study_plan(study)):
        theory = stability_of(case_of(request.posed()))
        assert theory is not None
        fastest = np.array([-math.tau / theory.fastest + 0j])
        predicted = DOP853_EVALUATIONS * float(stiffness_cost(order_8(), fastest))
        damping = dict(request.changes)["damping_rate"]
        by_solver = rates.setdefault(damping, {"predicted": predicted})
        run = study.answer(request)
        if run:
            by_solver[request.method] = run.steps / float(run.times[-1])
    return rates


def numbers(study: Study) -> Record | None:
    """Returns the largest stable steps that the study holds; None if it holds none."""
    judged = [limit for limit in study_limits(study) if limit.limit is not None]
    if not judged:
        return None
    surprises = [f"{x.scene} {x.method}: {x.surprise}" for x in judged if x.surprise]
    records = [limit.record() for limit in judged]
    return Record(
        limits=records,
        surprises=surprises,
        paid=evaluation_rates(study),
        predicted=sum(limit["verdict"] == "predicted" for limit in records),
        known=sum(bool(limit["known_limit"]) for limit in records),
    )


def claims(numbers: Record) -> Sequence[Claim]:
    """Returns the checks that no limit is unexpected, and that the first solver needs the
    evaluations that stability requires."""
    checks = [*as_expected(numbers.surprises)]
    for damping, by_solver in numbers.paid.items():
        if VARIABLE_STEP_SOLVERS[0] in by_solver:
            text = f"what DOP853 pays at {damping:g}/s beside what is predicted, less 1,"
            excess = by_solver[VARIABLE_STEP_SOLVERS[0]] / by_solver["predicted"] - 1.0
            checks.append(at_most(text, excess, EVALUATIONS_TOLERANCE))
    return checks


LARGEST_STEPS = Analysis("engines/largest_steps", numbers, requests, claims)
