"""Derivatives of slides, coasts and turns by their parameters: how far off they are on average over
neighbouring parameters, and how they scatter, with each contact setting."""

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
QUANTITIES = (  # scene, observable, parameter, and when [s]: sliding, sticking, or the end
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
FRICTIONS = np.linspace(0.25, 0.35, 33)  # of the curves
TANGENTS = slice(7, 26, 9)  # of them, where the derivatives are drawn
EPS = 3e-3  # of a parameter, or of its unit where that is 0: from one neighbour to the next
NEIGHBOURS = 4  # on either side, and as many derivatives
RIGHT, FALLS = 0.1, 2.0  # an error that converges: at most, and from step to step by so much
# at least, where the first order has 4; or no larger than this at the smaller step
RESOLVED = 1e-3
SMOOTH = 0.25  # of the mean error: the scatter of one that is smooth


def kind_of(errors: Array, scatter: Array) -> str:
    """Whether a derivative converges, is noise, or is smooth and wrong, by the mean errors at STEPS
    and their standard deviations."""
    sizes = np.hypot(errors, scatter)
    if sizes[-1] <= max(RESOLVED, min(RIGHT, sizes[0] / FALLS)):
        return "converges"
    return "noise" if scatter[-1] > SMOOTH * abs(errors[-1]) else "smooth and wrong"


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The curves of a slide, and neighbours: in the full profile of every quantity."""
    curves = (run for name in _drawn(plan) for run in _curve(name))
    pairs = product(_pairs(plan), STEPS)
    return (*curves, *(run for pair, step in pairs for run in _runs(*pair, step)))


def numbers(study: Study) -> Record | None:
    """The curves and derivatives that a study holds; None where it lacks a curve."""
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
        kinds=kinds,  # how many derivatives of each method are of each kind
        steps=STEPS,
        eps=EPS,
    )


def claims(numbers: Record) -> Claims:
    """That the derivative with the recommended contacts is nearer by far than by default."""
    size = {of.method: np.hypot(of.errors[-1], of.scatter[-1]) for of in numbers.nearby[::-1]}
    if not {DEFAULT, RECOMMENDED} <= set(size):
        return ()
    text = "the error of a derivative with default contacts, and with those recommended"
    return (clear(text, float(size[DEFAULT]), float(size[RECOMMENDED])),)


def _pairs(plan: StudyPlan) -> list[tuple[Quantity, str]]:
    """Quantities and methods that a plan has."""
    quick = plan.profile == "quick"
    pairs = product(QUANTITIES[: 1 if quick else None], CURVES[:2] if quick else METHODS)
    return [(quantity, name) for quantity, name in pairs if plan.has(quantity[0], name)]


def _drawn(plan: StudyPlan) -> list[str]:
    return [name for name in CURVES if plan.has(SLIDE, name)]


def _curve(method: str) -> list[ExtraRun]:
    return _varied(SLIDE, method, STEPS[0], None, "friction", FRICTIONS)


def _runs(quantity: Quantity, method: str, step: float) -> list[ExtraRun]:
    """A run with each neighbour, of rising values."""
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
    """An observable at the end of runs and of their exact motions, shape (2, n); (2, 0) where not
    all of them were made."""
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
    """Derivatives near a parameter's value: changes of an observable, in parts of its size, over
    the parameter's, and the errors of differences of runs; None where a run is missing."""
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
        at=at,  # [s]; None: the end
        method=method,
        exact=slopes[-1, 1, NEIGHBOURS - 1],
        errors=errors,  # their mean at STEPS
        scatter=scatter,  # and standard deviation
        kind=kind_of(errors, scatter),
    )


THROUGH_CONTACT = Analysis("engines/through_contact", numbers, requests, claims)
