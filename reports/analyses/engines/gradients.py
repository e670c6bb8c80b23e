"""Derivatives of final states, by each way of differentiating, beside their predicted errors."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import product
from typing import Any

from plumbob.engines.study.extra_runs import Requests, StudyPlan
from plumbob.engines.study.gradient import GradientSearch
from plumbob.engines.study.request import Request
from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import pairs
from plumbob.models.registry import case_of, system_of
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import as_expected
from plumbob.reports.judge.gradients import study_gradients

GRADIENT_SLIDE, OVERDAMPED_SWING = "capsule-line/heading-030", "linear-pendulum/overdamped"
LARGE_SWING, ROTATING_CONE = "simple-pendulum/free-large", "cone-pendulum/rotating-base"
# Derivatives in every study that has the pair of scene and method: (scene, method, observable,
# parameter, difference of the parameter). The runs are short, and the difference is near the best
# one.
SAMPLE = (
    (GRADIENT_SLIDE, "mujoco/euler", "displacement", "friction", 1e-3),
    (GRADIENT_SLIDE, "mujoco/euler+coulomb", "displacement", "friction", 1e-3),
    (GRADIENT_SLIDE, "pymunk/feet", "displacement", "friction", 1e-3),
    (OVERDAMPED_SWING, "mujoco/euler", "theta", "theta", 1e-3),
    (LARGE_SWING, "pymunk/default", "theta", "gravity", 1e-4),
    (ROTATING_CONE, "mujoco/euler", "theta", "theta", 1e-5),
    (ROTATING_CONE, "ode/rk4", "theta", "gravity", 1e-3),
)
# Derivatives that the full profile takes with one method of each engine, at three steps, to compare
# the ways of differentiating and their orders: (scene, observable, parameter, difference of the
# parameter, largest step [s], end [s], where None is the end of the scene).
COMPARED_DERIVATIVES = (
    (ROTATING_CONE, "theta", "theta", 1e-5, 4e-3, None),
    (LARGE_SWING, "theta", "theta", 1e-5, 1e-2, 2.0),
    ("free-body/flip", "angular_velocity_x", "angular_velocity[0]", 1e-5, 1e-2, 2.0),
    ("capsule-line/heading-000", "displacement", "w1", 4e-2, 1e-3, None),
    (GRADIENT_SLIDE, "displacement", "w1", 4e-2, 1e-3, None),
    ("capsule-turn/pivot", "heading", "angular_acceleration", 5e-2, 1e-3, None),
    ("capsule-coast/spin", "heading", "velocity_x", 4e-4, 1e-3, None),
)
WITHOUT_CONTACTS = (
    *("mujoco/euler", "mujoco/rk4", "mjx/default", "mjx/euler+float64", "drake/default"),
    *("pinocchio/aba+rk4", "ode/rk4", "ode/dop853", "heyoka/taylor", "pymunk/default"),
    *("pymunk/torque", "pybullet/default", "dart/default", "exudyn/default"),
)
WITH_CONTACTS = (
    *("mujoco/euler+coulomb", "drake/tamsi+stiction", "pymunk/feet", "dart/nsgs"),
    *("pinocchio/aba+rk4", "pybullet/undamped+iterated", "exudyn/default"),
)
Sampled = tuple[str, str, str, str, float, float | None, float | None]
# parameters to differentiate by: the first that is not 0 in the scene
PREFERRED_PARAMETERS = ("friction", "gravity")


def requests(plan: StudyPlan) -> Sequence[GradientSearch]:
    """Returns the searches for the derivatives of SAMPLE and, unless the profile is quick, of
    COMPARED_DERIVATIVES, as far as the plan has the pairs of scene and method."""

    derivatives: list[Sampled] = [(*entry, None, None) for entry in SAMPLE]
    if plan.profile != "quick":
        derivatives += _side_by_side()
    return [
        GradientSearch(
            scene=scene,
            method=method,
            of=(observable,),
            by=parameter,
            step=step if plan.method(method).control == "step" else None,
            eps=(eps,),
            at=end,
        )
        for scene, method, observable, parameter, eps, step, end in derivatives
        if plan.has(scene, method)
    ]


def _side_by_side() -> list[Sampled]:
    """Returns the derivatives of COMPARED_DERIVATIVES with a method of each engine, at the largest
    step, half of it and a quarter of it."""
    derivatives = list[Sampled]()
    for scene, observable, parameter, eps, step, end in COMPARED_DERIVATIVES:
        methods = WITH_CONTACTS if scene.startswith("capsule") else WITHOUT_CONTACTS
        derivatives += [
            (scene, method, observable, parameter, eps, step / divisor, end)
            for method, divisor in product(methods, (1, 2, 4))
        ]
    return derivatives


def with_each_pair(others: Requests) -> Requests:
    """Returns the requests `others`, extended for each pair of scene and method by searches for the
    derivatives of all quantities of interest by a parameter and by a start value."""

    def all_requests(plan: StudyPlan) -> Sequence[Request[Any]]:
        """Returns the requests `others` of a plan, and the searches of each pair."""
        searches = list[Request[Any]]()
        for scene, method in pairs(plan.scenes, plan.methods):
            observables = _observables_of_interest(scene)
            searches += [
                GradientSearch(scene.name, method.name, observables, parameter)
                for parameter in _differentiated_parameters(scene)
            ]
        return (*others(plan), *searches)

    return all_requests


def numbers(study: Study) -> Record | None:
    """Returns the judged derivatives of a study; None if it holds none."""
    judged = list(study_gradients(study))
    if not judged:
        return None
    surprises = [f"{d.scene} {d.method} {d.about}: {d.surprise}" for d in judged if d.surprise]
    records = [derivative.record() for derivative in judged]
    verdicts = Counter(record["verdict"] for record in records)
    return Record(records=records, surprises=surprises, verdicts=verdicts)


def _observables_of_interest(scene: Scene) -> tuple[str, ...]:
    """Returns the observables of a scene's quantities of interest."""
    case = case_of(scene)
    return tuple(quantity.observable for quantity in case.system.quantities(case))


def _differentiated_parameters(scene: Scene) -> list[str]:
    """Returns the parameters to differentiate by: the first of PREFERRED_PARAMETERS that is not 0
    in the scene, if there is one, and the first start value."""
    preferred = [name for name in PREFERRED_PARAMETERS if scene.parameters.get(name)]
    start = system_of(scene).start
    # A scene may state its start by other parameters, such as the distance from the top. If it
    # states none of `start`, the first of `start` is taken.
    stated = [name for name in start if name in scene.parameters] or start
    return [*preferred[:1], *stated[:1]]


GRADIENTS = Analysis(
    "engines/gradients", numbers, requests, lambda record: as_expected(record.surprises)
)
