"""The page's section on the capsule coasting to rest: what a step does to a stop and to a spin."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Section
from plumbob.reports.analyses.claims import ALIKE, at_most, between
from plumbob.reports.analyses.measurements import case, covers, measured, problem, runs, scheme
from plumbob.reports.view.content import Claim

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


@dataclass(frozen=True)
class StopErrors:
    """A method's errors of the stopping distance over v0 dt/2, measured and predicted, by step."""

    method: str
    errors: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Stopping:
    """A body that slides straight, and where it stops in engines."""

    speed: float  # [m/s]
    distance: float  # [m]
    spinning: float  # time [s] until one rests that spins too
    rows: tuple[StopErrors, ...]
    steps: tuple[float, ...] = STEPS

    @property
    def time(self) -> float:
        """Until it rests [s]: v0/(f g)."""
        return 2.0 * self.distance / self.speed


def stopping_requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Runs to rest."""
    return runs((SCENE,), METHODS, STEPS)


def stopping(study: Study) -> Stopping | None:
    """Errors of the stopping distance in both engines; None where neither ran."""
    posed = problem(SCENE)
    speed, distance = math.hypot(*posed.setup.velocity), float(posed.motion.coasting.distance)
    rows = []
    for name in METHODS:
        errors = [_stop_errors(study, name, step, speed, distance) for step in STEPS]
        known = tuple(pair for pair in errors if pair is not None)
        if len(known) == len(STEPS):
            rows.append(StopErrors(name, known))
    spinning = problem(SPIN).motion.rest_time
    return Stopping(speed, distance, spinning, tuple(rows)) if rows else None


def _stop_errors(
    study: Study, name: str, step: float, speed: float, distance: float
) -> tuple[float, float] | None:
    run = study.recording(ExtraRun(SCENE, name, step))
    if run is None:
        return None
    half = 0.5 * speed * step
    travelled = math.hypot(run.observables["x"][-1], run.observables["y"][-1])
    return (travelled - distance) / half, _predicted_end(name, step, run.times) / half


def _predicted_end(method: str, step: float, times: Array) -> float:
    """The predicted error of the stopping distance [m]: positive where it is too long."""
    predicted = case(SCENE).errors.at_step(scheme(method), step, times).errors
    x, y = predicted["x"][-1], predicted["y"][-1]
    return math.copysign(math.hypot(x, y), x)


def stopping_claims(numbers: Stopping) -> Sequence[Claim]:
    """The error at the smallest step is as predicted, but on default contacts."""
    left = {row.method: row.errors[-1][0] - row.errors[-1][1] for row in numbers.rows}
    text = "what theory leaves of the error of {}, over v₀dt/2,"
    return [at_most(text.format(n), size, ALIKE) for n, size in left.items() if n != DEFAULT]


@dataclass(frozen=True)
class HeadingErrors:
    """A method's errors of the heading at rest [rad], by step."""

    method: str
    errors: tuple[float, ...]
    slope: float | None  # error over step [rad/s] that is predicted at the smallest

    @property
    def ratios(self) -> tuple[float, ...]:
        """Errors over steps [rad/s]."""
        return tuple(error / step for error, step in zip(self.errors, DECADE, strict=True))

    @property
    def line(self) -> tuple[float, ...]:
        """The slope times the steps [rad]."""
        return tuple((self.slope or 0.0) * step for step in DECADE)


@dataclass(frozen=True)
class DefaultRun:
    """A run on default contacts."""

    step: float  # [s]
    heading: float  # error at rest [rad]
    rate: float  # largest error [rad/s]
    missing: float  # fraction of samples with a contact missing while it moves


@dataclass(frozen=True)
class Defaults:
    """Runs on default contacts at the same steps."""

    runs: tuple[DefaultRun, ...]
    least: float  # error of the heading [rad]
    most: float
    missing: float  # the least


@dataclass(frozen=True)
class Spin:
    """A body that spins and slides at once."""

    methods: tuple[HeadingErrors, ...]
    default: Defaults | None
    steps: tuple[float, ...] = DECADE


def spin_requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Runs on default contacts, where the study measures the spin."""
    return runs((SPIN,), (DEFAULT,), DECADE) if covers(plan, SPIN) else ()


def spin(study: Study) -> Spin | None:
    """Errors of the heading at rest over a decade of steps, where the study has it; and what
    default contacts do."""
    if not covers(study, SPIN):
        return None
    errors = [_heading_errors(study, name) for name in SPINNING]
    methods = tuple(method for method in errors if method is not None)
    if all(method.slope is None for method in methods):
        return None
    return Spin(methods, _defaults(study))


def _heading_errors(study: Study, name: str) -> HeadingErrors | None:
    measurements = [measured(study, SPIN, name, step) for step in DECADE]
    errors = [run.errors["heading"] for run in measurements if run is not None]
    if len(errors) < len(DECADE):
        return None
    last = errors[-1].predicted
    slope = None if name == DEFAULT or last is None else last.end / DECADE[-1]
    return HeadingErrors(name, tuple(error.end for error in errors), slope)


def _defaults(study: Study) -> Defaults | None:
    rows = []
    rest_time = problem(SPIN).motion.rest_time
    for step in DECADE:
        run = measured(study, SPIN, DEFAULT, step)
        recording = study.recording(ExtraRun(SPIN, DEFAULT, step))
        if run is None or recording is None:
            return None
        contacts = recording.channels["contacts"][recording.times < rest_time]
        heading, rate = run.errors["heading"], run.errors["heading_rate"]
        rows.append(DefaultRun(step, heading.end, rate.largest, float(np.mean(contacts < 3))))
    sizes = [abs(row.heading) for row in rows]
    return Defaults(tuple(rows), min(sizes), max(sizes), min(row.missing for row in rows))


def spin_claims(numbers: Spin) -> Sequence[Claim]:
    """Errors fall in proportion to the step."""
    decade = DECADE[0] / DECADE[-1]
    return [
        between(
            f"the error of {method.method}, at ten times the step over at the step,",
            method.errors[0] / method.errors[-1] if method.errors[-1] else 0.0,
            0.5 * decade,
            2.0 * decade,
        )
        for method in numbers.methods
        if method.slope is not None
    ]


STOPPING = Analysis("capsule_coast/stopping", stopping, stopping_requests, stopping_claims)
SECTION = Section(
    (STOPPING, Analysis("capsule_coast/spin", spin, spin_requests, spin_claims)),
)
