"""The page's section on the capsule coasting to rest: what a step does to a stop."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from plumbob.analytic.reference import Array
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record, Section
from plumbob.reports.analyses.claims import ALIKE, Claims, at_most
from plumbob.reports.analyses.measurements import case, problem, runs, scheme

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


STOPPING = Analysis("capsule_coast/stopping", stopping, stopping_requests, stopping_claims)
SECTION = Section((STOPPING,))
