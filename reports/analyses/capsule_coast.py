"""The page's section on the capsule coasting to rest: what a step does to a stop and to a spin."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record, Section
from plumbob.reports.analyses.claims import ALIKE, Claims, at_most, between
from plumbob.reports.analyses.measurements import case, covers, measured, problem, runs, scheme

SCENE = "capsule-coast/translation"
DEFAULT = "mujoco/euler"
METHODS = (
    DEFAULT,
    "mujoco/euler+coulomb",
    "mujoco/euler+reduced",
    "pymunk/feet",
    "pymunk/side",
)
STEPS = (1e-3, 1e-4)
SPIN = "capsule-coast/spin"
SPINNING = ("mujoco/euler+coulomb", "mujoco/rk4+coulomb", "pymunk/feet", DEFAULT)
DECADE = (1e-3, 5e-4, 2e-4, 1e-4)
Pair = tuple[float, float]


def stopping_requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Runs to rest."""
    return runs((SCENE,), METHODS, STEPS)


def stopping(study: Study) -> Record | None:
    """Errors of the stopping distance in both engines; None where neither ran."""
    posed, spinning = problem(SCENE), problem(SPIN).motion.rest_time
    speed, distance = math.hypot(*posed.setup.velocity), float(posed.motion.coasting.distance)
    errors = {name: _stop_errors(study, name, speed, distance) for name in METHODS}
    rows = {name: pairs for name, pairs in errors.items() if len(pairs) == len(STEPS)}
    if not rows:
        return None
    return Record(
        speed=speed,  # [m/s]
        distance=distance,  # [m]
        spinning=spinning,  # time [s] until one rests that spins too
        rows=rows,  # by method and step: measured, predicted, over v0 dt/2
        steps=STEPS,
        time=2.0 * distance / speed,  # until it rests [s]: v0/(f g)
    )


def _stop_errors(study: Study, name: str, speed: float, distance: float) -> list[Pair]:
    """By step, of those that have a run."""
    pairs = []
    for step in STEPS:
        if run := study.answer(ExtraRun(SCENE, name, step)):
            error, half = _way(run.observables) - distance, 0.5 * speed * step
            predicted = _way(case(SCENE).errors.at_step(scheme(name), step, run.times).errors)
            pairs.append((error / half, predicted / half))
    return pairs


def _way(observed: Mapping[str, Array]) -> float:
    """How far a body is at the end, or its error [m]: positive where it is too far."""
    x, y = observed["x"][-1], observed["y"][-1]
    return math.copysign(math.hypot(x, y), x)


def stopping_claims(numbers: Record) -> Claims:
    """The error at the smallest step is as predicted, but on default contacts."""
    text = "what theory leaves of the error of {}, over v₀dt/2,"
    ends = {name: pairs[-1] for name, pairs in numbers.rows.items() if name != DEFAULT}
    return [at_most(text.format(name), end[0] - end[1], ALIKE) for name, end in ends.items()]


def spin_requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Runs on default contacts, where the study measures the spin."""
    return runs((SPIN,), (DEFAULT,), DECADE) if covers(plan, SPIN) else ()


def spin(study: Study) -> Record | None:
    """Errors of the heading at rest over a decade of steps, where the study has it; and what
    default contacts do."""
    if not covers(study, SPIN):
        return None
    errors = [_heading_errors(study, name) for name in SPINNING]
    methods = tuple(filter(None, errors))
    if all(method.slope is None for method in methods):
        return None
    runs = [_default_run(study, step) for step in DECADE]
    default = tuple(filter(None, runs))
    default = default if len(default) == len(DECADE) else ()
    sizes = sorted(abs(run.heading) for run in default)
    return Record(
        methods=methods,
        default=default,
        steps=DECADE,
        # least and largest error of the heading [rad] on default contacts, if there are any
        default_range=sizes[:1] + sizes[-1:],
        # the least fraction of samples with a contact missing there
        missing=min((run.missing for run in default), default=None),
    )


def _heading_errors(study: Study, name: str) -> Record | None:
    """A method's errors of the heading at rest [rad], by step."""
    measurements = [measured(study, SPIN, name, step) for step in DECADE]
    errors = [run.errors["heading"] for run in measurements if run]
    if len(errors) < len(DECADE):
        return None
    ends, steps = np.array([error.end for error in errors]), np.array(DECADE)
    predicted = None if name == DEFAULT else errors[-1].predicted
    slope = predicted.end / DECADE[-1] if predicted else None
    return Record(
        method=name,
        errors=ends,
        ratios=ends / steps,  # over the step [rad/s]
        slope=slope,  # the ratio that is predicted at the smallest step
        line=(slope or 0.0) * steps,  # slope times step
    )


def _default_run(study: Study, step: float) -> Record | None:
    """A run on default contacts."""
    run = measured(study, SPIN, DEFAULT, step)
    recording = study.answer(ExtraRun(SPIN, DEFAULT, step))
    if run is None or recording is None:
        return None
    moving = recording.times < problem(SPIN).motion.rest_time
    missing = float(np.mean(recording.channels["contacts"][moving] < 3))
    return Record(
        step=step,  # [s]
        heading=run.errors["heading"].end,  # error at rest [rad]
        rate=run.errors["heading_rate"].largest,  # largest error [rad/s]
        missing=missing,  # fraction of samples with a contact missing while it moves
    )


def spin_claims(numbers: Record) -> Claims:
    """Errors fall in proportion to the step."""
    text = "the error of {}, at ten times the step over at the step,"
    ends = {row.method: row.errors for row in numbers.methods if row.slope is not None}
    falls = {name: sizes[0] / sizes[-1] if sizes[-1] else 0.0 for name, sizes in ends.items()}
    return [between(text.format(name), fall, 5.0, 20.0) for name, fall in falls.items()]


STOPPING = Analysis("capsule_coast/stopping", stopping, stopping_requests, stopping_claims)
SECTION = Section((STOPPING, Analysis("capsule_coast/spin", spin, spin_requests, spin_claims)))
