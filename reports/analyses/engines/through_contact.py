"""Derivatives through contact of slides, coasts and turns: mean error and scatter over neighbouring
parameters, for each contact setting."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import product

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_line.headings import (
    DEFAULT_CONTACTS,
    RECOMMENDED_CONTACTS,
)
from plumbob.reports.analyses.claims import Claims, clearly_larger
from plumbob.reports.analyses.measurements import recordings, study_plan

SLIDING_SCENE, COASTING_SCENE = "capsule-line/heading-030", "capsule-coast/translation"
SPINNING_SCENE, TURNING_SCENE = "capsule-coast/spin", "capsule-turn/pivot"
CONTACT_CURVES = (DEFAULT_CONTACTS, RECOMMENDED_CONTACTS, "pymunk/feet")
METHODS = (
    *(
        DEFAULT_CONTACTS,
        "mujoco/euler+elliptic",
        "mujoco/euler+elliptic+noslip",
        RECOMMENDED_CONTACTS,
    ),
    *("mujoco/euler+coulomb+noslip", "mujoco/rk4+coulomb", "pymunk/feet", "pymunk/pivots"),
    *("dart/default", "dart/nsgs", "drake/default", "drake/similar", "drake/tamsi+stiction"),
    *("pybullet/default", "pybullet/undamped+iterated"),
)
DERIVATIVE_CASES = (  # scene, observable, parameter, time [s] (sliding or sticking; None: the end)
    (SLIDING_SCENE, "displacement", "friction", None),
    (SLIDING_SCENE, "displacement", "friction", 0.045),
    (SLIDING_SCENE, "displacement", "friction", 0.063),
    (SLIDING_SCENE, "displacement", "w1", None),
    (SLIDING_SCENE, "displacement", "slider_mass", None),
    (SLIDING_SCENE, "displacement", "heading", None),
    (COASTING_SCENE, "x", "friction", None),
    (COASTING_SCENE, "x", "velocity_x", None),
    (SPINNING_SCENE, "heading", "friction", None),
    (SPINNING_SCENE, "heading", "slider_mass", None),
    (TURNING_SCENE, "heading", "friction", None),
    (TURNING_SCENE, "heading", "angular_acceleration", None),
)
DerivativeCase = tuple[str, str, str, float | None]
DERIVATIVE_STEPS = (1e-3, 2.5e-4)  # [s]
FRICTIONS = np.linspace(0.25, 0.35, 33)  # friction coefficients of the curves
TANGENTS = slice(7, 26, 9)  # indices of the frictions at which derivatives are drawn
EPS = 3e-3  # distance of neighbours, relative to the parameter (or to its unit, if it is 0)
NEIGHBOURS = 4  # number of neighbours on either side
# A derivative converges if its relative error at the smaller step is at most CONVERGED_ERROR and
# the ratio of the errors at both steps is ERROR_RATIO or more (first order gives 4); or if the
# error at the smaller step is at most RESOLVED_DERIVATIVE.
CONVERGED_ERROR, ERROR_RATIO = 0.1, 2.0
RESOLVED_DERIVATIVE = 1e-3
SMOOTH_SCATTER = 0.25  # largest scatter of a smooth error, relative to its mean


def kind_of(errors: Array, scatter: Array) -> str:
    """Returns the kind of a derivative: "converges", "noise" or "smooth and wrong". `errors` are
    the mean errors at DERIVATIVE_STEPS, shape (2,), and `scatter` their standard deviations."""
    sizes = np.hypot(errors, scatter)
    if sizes[-1] <= max(RESOLVED_DERIVATIVE, min(CONVERGED_ERROR, sizes[0] / ERROR_RATIO)):
        return "converges"
    return "noise" if scatter[-1] > SMOOTH_SCATTER * abs(errors[-1]) else "smooth and wrong"


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Returns the runs of the slide's curves and of the neighbours of each quantity in the
    profile."""
    requested = list[ExtraRun]()
    for name in _methods_of_curves(plan):
        requested += _curve_runs(name)
    for (quantity, method), step in product(_pairs(plan), DERIVATIVE_STEPS):
        requested += _neighbour_runs(quantity, method, step)
    return requested


def numbers(study: Study) -> Record | None:
    """Returns the curves of displacement against friction, and the derivatives of the quantities;
    None if the study holds no complete curve."""
    plan = study_plan(study)
    curves = dict[str, Array]()
    for name in _methods_of_curves(plan):
        measured, exact = _final_values(study, _curve_runs(name), "displacement")
        if measured.size:
            curves[name] = measured
            curves.setdefault("exact", exact)
    if not curves:
        return None
    curves["exact"] = curves.pop("exact")  # the exact curve is drawn last
    derivatives = [_derivative_errors(study, *pair) for pair in _pairs(plan)]
    nearby = [derivative for derivative in derivatives if derivative]
    kinds: dict[str, Counter[str]] = {}
    for derivative in nearby:
        kinds.setdefault(derivative.method, Counter())[derivative.kind] += 1
    slopes = {name: np.gradient(curve, FRICTIONS) for name, curve in curves.items()}
    return Record(
        frictions=FRICTIONS,
        displacements=curves,  # [m], by method and "exact"
        # friction, displacement [m] and its derivative [m]
        tangents={
            name: np.array([FRICTIONS, curve, slopes[name]]).T[TANGENTS]
            for name, curve in curves.items()
        },
        nearby=nearby,
        kinds=kinds,  # number of derivatives of each kind, by method
        steps=DERIVATIVE_STEPS,
        eps=EPS,
    )


def claims(numbers: Record) -> Claims:
    """Returns the checks that the error of the derivative with recommended contacts is far below
    the error with default contacts."""
    # reversed, so that the first derivative of each method stays
    sizes = {d.method: np.hypot(d.errors[-1], d.scatter[-1]) for d in numbers.nearby[::-1]}
    if not {DEFAULT_CONTACTS, RECOMMENDED_CONTACTS} <= set(sizes):
        return ()
    text = "the error of a derivative with default contacts, and with those recommended"
    return (
        clearly_larger(
            text, float(sizes[DEFAULT_CONTACTS]), float(sizes[RECOMMENDED_CONTACTS])
        ),
    )


def _pairs(plan: StudyPlan) -> list[tuple[DerivativeCase, str]]:
    """Returns the pairs of quantity and method that a plan covers."""
    quick = plan.profile == "quick"
    quantities = DERIVATIVE_CASES[:1] if quick else DERIVATIVE_CASES
    methods = CONTACT_CURVES[:2] if quick else METHODS
    pairs = product(quantities, methods)
    return [(quantity, name) for quantity, name in pairs if plan.has(quantity[0], name)]


def _methods_of_curves(plan: StudyPlan) -> list[str]:
    """Returns the methods whose curves a plan can draw."""
    return [name for name in CONTACT_CURVES if plan.has(SLIDING_SCENE, name)]


def _curve_runs(method: str) -> list[ExtraRun]:
    """Returns the runs of a method's curve: the slide at each of FRICTIONS."""
    return _varied_runs(SLIDING_SCENE, method, DERIVATIVE_STEPS[0], None, "friction", FRICTIONS)


def _neighbour_runs(quantity: DerivativeCase, method: str, step: float) -> list[ExtraRun]:
    """Returns a run with each neighbouring value of the parameter, in ascending order."""
    name, _, parameter, end = quantity
    value = find_scene(name).parameters[parameter]
    spacing = EPS * (abs(value) or 1.0)
    values = value + spacing * np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
    return _varied_runs(name, method, step, end, parameter, values)


def _varied_runs(
    scene: str, method: str, step: float, end: float | None, parameter: str, values: Array
) -> list[ExtraRun]:
    """Returns a run with each of the values of a parameter, shape (n,), until `end` [s]."""
    changes = [((parameter, value),) for value in values.tolist()]
    return [ExtraRun(scene, method, step, end, change, end_alone=True) for change in changes]


def _final_values(study: Study, runs: Sequence[ExtraRun], observable: str) -> Array:
    """Returns the final values of an observable in runs (row 0) and in their exact motions (row 1),
    shape (2, n); shape (2, 0) if a run is missing."""
    recorded = recordings(study, runs)
    if len(recorded) < len(runs):
        return np.empty((2, 0))
    ends = []
    for request, run in recorded.items():
        case = case_of(find_scene(request.scene, dict(request.changes)))
        exact = case.reference.observe(run.times[-1:])
        ends.append((run.observables[observable][-1], exact[observable][0]))
    return np.array(ends).T


def _derivative_errors(study: Study, quantity: DerivativeCase, method: str) -> Record | None:
    """Returns the errors of a quantity's derivatives near a parameter's value; None if a run is
    missing. A derivative is the relative change of the observable over the relative change of the
    parameter."""
    scene, observable, parameter, end = quantity
    values = [
        _final_values(study, _neighbour_runs(quantity, method, step), observable)
        for step in DERIVATIVE_STEPS
    ]
    if not all(at_step.size for at_step in values):
        return None
    size = abs(values[0][1, NEIGHBOURS])
    differences = np.array([at_step[:, 2:] - at_step[:, :-2] for at_step in values])
    slopes = differences / (2 * EPS * size)  # shape (steps, 2, neighbours): runs, exact motions
    deviations = slopes[:, 0] - slopes[:, 1]
    errors = deviations.mean(axis=1)
    scatter = deviations.std(axis=1)
    return Record(
        scene=scene,
        of=observable,
        by=parameter,
        at=end,  # [s] time of the observable; None: the end
        method=method,
        exact=slopes[-1, 1, NEIGHBOURS - 1],
        errors=errors,  # mean error at each of DERIVATIVE_STEPS
        scatter=scatter,  # standard deviation of the error at each of DERIVATIVE_STEPS
        kind=kind_of(errors, scatter),
    )


THROUGH_CONTACT = Analysis("engines/through_contact", numbers, requests, claims)
