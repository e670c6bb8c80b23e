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
from plumbob.reports.analyses.capsule_line.headings import DEFAULT, RECOMMENDED
from plumbob.reports.analyses.claims import Claims, clear
from plumbob.reports.analyses.measurements import plan_of, recordings

SLIDE, COAST = "capsule-line/heading-030", "capsule-coast/translation"
SPIN, TURN = "capsule-coast/spin", "capsule-turn/pivot"
CURVES = (DEFAULT, RECOMMENDED, "pymunk/feet")
METHODS = (
    *(DEFAULT, "mujoco/euler+elliptic", "mujoco/euler+elliptic+noslip", RECOMMENDED),
    *("mujoco/euler+coulomb+noslip", "mujoco/rk4+coulomb", "pymunk/feet", "pymunk/pivots"),
    *("dart/default", "dart/nsgs", "drake/default", "drake/similar", "drake/tamsi+stiction"),
    *("pybullet/default", "pybullet/undamped+iterated"),
)
QUANTITIES = (  # scene, observable, parameter, time [s] (sliding or sticking; None: the end)
    (SLIDE, "displacement", "friction", None),
    (SLIDE, "displacement", "friction", 0.045),
    (SLIDE, "displacement", "friction", 0.063),
    (SLIDE, "displacement", "w1", None),
    (SLIDE, "displacement", "slider_mass", None),
    (SLIDE, "displacement", "heading", None),
    (COAST, "x", "friction", None),
    (COAST, "x", "velocity_x", None),
    (SPIN, "heading", "friction", None),
    (SPIN, "heading", "slider_mass", None),
    (TURN, "heading", "friction", None),
    (TURN, "heading", "angular_acceleration", None),
)
Quantity = tuple[str, str, str, float | None]
STEPS = (1e-3, 2.5e-4)  # [s]
FRICTIONS = np.linspace(0.25, 0.35, 33)  # friction coefficients of the curves
TANGENTS = slice(7, 26, 9)  # indices of the frictions at which derivatives are drawn
EPS = 3e-3  # distance of neighbours, relative to the parameter (or to its unit, if it is 0)
NEIGHBOURS = 4  # number of neighbours on either side
# A derivative converges if its relative error at the smaller step is at most RIGHT and the ratio of
# the errors at both steps is at least FALLS (first order gives 4); or if the error at the smaller
# step is at most RESOLVED.
RIGHT, FALLS = 0.1, 2.0
RESOLVED = 1e-3
SMOOTH = 0.25  # largest scatter of a smooth error, relative to its mean


def kind_of(errors: Array, scatter: Array) -> str:
    """Returns the kind of a derivative: "converges", "noise" or "smooth and wrong". `errors` are
    the mean errors at STEPS, shape (2,), and `scatter` their standard deviations."""
    sizes = np.hypot(errors, scatter)
    if sizes[-1] <= max(RESOLVED, min(RIGHT, sizes[0] / FALLS)):
        return "converges"
    return "noise" if scatter[-1] > SMOOTH * abs(errors[-1]) else "smooth and wrong"


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Returns the runs of the slide's curves and of the neighbours of each quantity in the
    profile."""
    curves = (run for name in _drawn(plan) for run in _curve(name))
    pairs = product(_pairs(plan), STEPS)
    return (*curves, *(run for pair, step in pairs for run in _runs(*pair, step)))


def numbers(study: Study) -> Record | None:
    """Returns the curves of displacement against friction, and the derivatives of the quantities;
    None if the study holds no complete curve."""
    plan = plan_of(study)
    ends = {name: _ends(study, _curve(name), "displacement") for name in _drawn(plan)}
    curves = {name: of[0] for name, of in ends.items() if of.size}
    if not curves:
        return None
    curves["exact"] = next(of[1] for of in ends.values() if of.size)
    nearby = [of for pair in _pairs(plan) if (of := _nearby(study, *pair))]
    kinds: dict[str, Counter[str]] = {}
    for of in nearby:
        kinds.setdefault(of.method, Counter())[of.kind] += 1
    return Record(
        frictions=FRICTIONS,
        displacements=curves,  # [m], by method and "exact"
        # friction, displacement [m] and its derivative [m]
        tangents={
            name: np.array([FRICTIONS, curve, np.gradient(curve, FRICTIONS)]).T[TANGENTS]
            for name, curve in curves.items()
        },
        nearby=nearby,
        kinds=kinds,  # number of derivatives of each kind, by method
        steps=STEPS,
        eps=EPS,
    )


def claims(numbers: Record) -> Claims:
    """Returns the checks that the error of the derivative with recommended contacts is far below
    the error with default contacts."""
    size = {of.method: np.hypot(of.errors[-1], of.scatter[-1]) for of in numbers.nearby[::-1]}
    if not {DEFAULT, RECOMMENDED} <= set(size):
        return ()
    text = "the error of a derivative with default contacts, and with those recommended"
    return (clear(text, float(size[DEFAULT]), float(size[RECOMMENDED])),)


def _pairs(plan: StudyPlan) -> list[tuple[Quantity, str]]:
    """Returns the pairs of quantity and method that a plan covers."""
    quick = plan.profile == "quick"
    pairs = product(QUANTITIES[: 1 if quick else None], CURVES[:2] if quick else METHODS)
    return [(quantity, name) for quantity, name in pairs if plan.has(quantity[0], name)]


def _drawn(plan: StudyPlan) -> list[str]:
    return [name for name in CURVES if plan.has(SLIDE, name)]


def _curve(method: str) -> list[ExtraRun]:
    return _varied(SLIDE, method, STEPS[0], None, "friction", FRICTIONS)


def _runs(quantity: Quantity, method: str, step: float) -> list[ExtraRun]:
    """Returns a run with each neighbouring value of the parameter, in ascending order."""
    name, _, by, at = quantity
    value = find_scene(name).parameters[by]
    beside = value + EPS * (abs(value) or 1.0) * np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
    return _varied(name, method, step, at, by, beside)


def _varied(
    name: str, method: str, step: float, at: float | None, by: str, values: Array
) -> list[ExtraRun]:
    changes = [((by, value),) for value in values.tolist()]
    return [ExtraRun(name, method, step, at, change, end_alone=True) for change in changes]


def _ends(study: Study, runs: Sequence[ExtraRun], of: str) -> Array:
    """Returns the final values of the observable `of` in runs (row 0) and in their exact motions
    (row 1), shape (2, n); shape (2, 0) if a run is missing."""
    recorded = recordings(study, runs)
    if len(recorded) < len(runs):
        return np.empty((2, 0))
    ends = []
    for request, run in recorded.items():
        case = case_of(find_scene(request.scene, dict(request.changes)))
        exact = case.reference.observe(run.times[-1:])
        ends.append((run.observables[of][-1], exact[of][0]))
    return np.array(ends).T


def _nearby(study: Study, quantity: Quantity, method: str) -> Record | None:
    """Returns the errors of a quantity's derivatives near a parameter's value; None if a run is
    missing. A derivative is the relative change of the observable over the relative change of the
    parameter."""
    scene, of, by, at = quantity
    ends = [_ends(study, _runs(quantity, method, step), of) for step in STEPS]
    if not all(end.size for end in ends):
        return None
    size = abs(ends[0][1, NEIGHBOURS])
    slopes = np.array([(end[:, 2:] - end[:, :-2]) / (2 * EPS * size) for end in ends])
    off = slopes[:, 0] - slopes[:, 1]
    errors = off.mean(axis=1)
    scatter = off.std(axis=1)
    return Record(
        scene=scene,
        of=of,
        by=by,
        at=at,  # [s] time of the observable; None: the end
        method=method,
        exact=slopes[-1, 1, NEIGHBOURS - 1],
        errors=errors,  # mean error at each of STEPS
        scatter=scatter,  # standard deviation of the error at each of STEPS
        kind=kind_of(errors, scatter),
    )


THROUGH_CONTACT = Analysis("engines/through_contact", numbers, requests, claims)
