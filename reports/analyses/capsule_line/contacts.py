"""Contacts: chatter of the default ones, dependence on heading, normal forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.claims import at_most, clear
from plumbob.reports.analyses.contact_terms import LOADS
from plumbob.reports.analyses.measurements import (
    LINE,
    case,
    displacement_error,
    problem,
    runs,
    scheme,
)
from plumbob.reports.view.content import Claim

DEFAULT, CONVERGENT = "mujoco/euler", "mujoco/euler+coulomb"
STEPS = (1e-3, 1e-4)  # [s]; the figures are at the finer one
FLOOR = 1e-14  # [m] where a vertical displacement of zero is drawn
TURNED = ("mujoco/euler", "mujoco/euler+elliptic", "mujoco/euler+coulomb", "pymunk/feet")
HEADINGS, ALL_HEADINGS = (0, 30, 105, 225), tuple(range(0, 360, 15))  # [degrees]; quick, full
STATICS, STATICS_STEP = "capsule-line/at-123", 1e-4
STATICS_METHODS = ("mujoco/euler+coulomb", "pymunk/side")
ALIKE_AT_ALL = 1e-4  # of the displacement: headings that differ by less do not tell
CHATTERS = 1e-3  # of the samples: a contact is missing in many times that
TRUSTED = 1e-3  # of a normal force: what is nearer to statics can be trusted
SETTLED = 60  # steps: contacts of damping 0.3 have come to rest


@dataclass(frozen=True)
class ContactRun:
    """How the contacts of a method behave at a step."""

    method: str
    step: float  # [s]
    error: float | None  # of the displacement, relative
    vertical_range: float  # [m]
    missing: float  # fraction of samples with a contact missing while the body slides
    times: Array  # [s], of the rows below
    heights: Array  # [m], above zero
    contacts: Array
    loads: Array  # sum of normal forces over the weight


@dataclass(frozen=True)
class Chatter:
    """Default and convergent contacts at both steps."""

    coarse: tuple[ContactRun, ...]
    fine: tuple[ContactRun, ...]


@dataclass(frozen=True)
class Headings:
    """Relative errors of the displacement over the headings, of a method at a step."""

    method: str
    step: float  # [s]
    errors: Array

    @property
    def lowest(self) -> float:
        """The lowest error, with its sign."""
        return float(self.errors.min())

    @property
    def highest(self) -> float:
        """The highest error."""
        return float(self.errors.max())

    @property
    def spread(self) -> float:
        """By how much the errors differ."""
        return self.highest - self.lowest


@dataclass(frozen=True)
class HeadingError:
    """A heading and the size of the error along it."""

    angle: int  # [degrees]
    size: float  # relative

    @property
    def off_axis(self) -> int:
        """Angle to the nearest axis of the friction pyramid [degrees]."""
        return abs((self.angle + 45) % 90 - 45)


@dataclass(frozen=True)
class Isotropy:
    """Errors over the headings of a scene that is turned as a whole."""

    angles: tuple[int, ...]  # [degrees]
    step: float  # [s], of the figure and the texts
    every: tuple[Headings, ...]
    best: HeadingError | None  # with default contacts
    worst: HeadingError | None
    default_spread: float | None
    convergent_spread: float | None


@dataclass(frozen=True)
class LoadErrors:
    """Relative distances of a method's normal forces from statics, the largest of the three."""

    method: str
    at_rest: float  # the largest after the motion
    times: Array  # [s]
    distances: Array
    half_step: Array  # distances from statics with the predicted error of the step

    @property
    def largest(self) -> float:
        """The largest of all times."""
        return float(self.distances.max())

    @property
    def largest_half_step(self) -> float:
        """The same with the predicted error of the step."""
        return float(self.half_step[:-1].max())


@dataclass(frozen=True)
class Loads:
    """Normal forces of engines against statics."""

    engines: tuple[LoadErrors, ...]
    at_rest: float  # the largest of all
    scene: str = STATICS
    step: float = STATICS_STEP


def chatter_requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Default and convergent contacts."""
    return runs((LINE,), (DEFAULT, CONVERGENT), STEPS)


def isotropy_requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The headings of the profile."""
    headings, steps = _turned(plan.profile)
    return runs(map(_at_heading, headings), TURNED, steps)


def load_requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Normal forces at a fine step."""
    return runs((STATICS,), STATICS_METHODS, (STATICS_STEP,))


def chatter(study: Study) -> Chatter | None:
    """Vertical displacement, contacts and normal force over time, default against convergent; None
    where either did not run."""
    every = [_contacts(study, method, step) for step in STEPS for method in (DEFAULT, CONVERGENT)]
    known = tuple(run for run in every if run is not None)
    return Chatter(known[:2], known[2:]) if len(known) == len(every) else None


def _contacts(study: Study, method: str, step: float) -> ContactRun | None:
    if (run := study.recording(ExtraRun(LINE, method, step))) is None:
        return None
    motion = problem(LINE).motion
    height, contacts = run.channels["vertical_displacement"], run.channels["contacts"]
    return ContactRun(
        method,
        step,
        displacement_error(study, LINE, method, step),
        float(np.ptp(height)),
        float(np.mean(contacts[run.times < motion.t_star] < 3)),
        run.times,
        np.maximum(np.abs(height), FLOOR),
        contacts,
        np.sum([run.observables[load] for load in LOADS], axis=0) / motion.capsule.weight,
    )


def _chatters(numbers: Chatter) -> Sequence[Claim]:
    default, convergent = numbers.fine
    errors = (default.error or 0.0, convergent.error or 0.0)
    missing = default.missing
    return (
        clear("errors with default contacts, and with those that converge", *errors),
        clear("the part of samples with a contact missing, and 0.001", missing, CHATTERS),
    )


def _turned(profile: str) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Headings [degrees] and steps [s] of a profile."""
    return (ALL_HEADINGS, (1e-3, 1e-4)) if profile == "full" else (HEADINGS, (1e-3,))


def _at_heading(angle: int) -> str:
    return f"capsule-line/heading-{angle:03d}"


def isotropy(study: Study) -> Isotropy | None:
    """Relative error of the displacement at each heading, and its spread."""
    angles, steps = _turned(study.profile)
    scenes = [_at_heading(angle) for angle in angles]
    every = list[Headings]()
    for method, step in product(TURNED, steps):
        errors = [displacement_error(study, scene, method, step) for scene in scenes]
        known = np.array([error for error in errors if error is not None])
        if len(known) == len(angles):
            every.append(Headings(method, step, known))
    if not every:
        return None
    spreads = {headings.method: headings.spread for headings in every if headings.step == steps[0]}
    sizes = [
        HeadingError(angle, abs(error))
        for angle, scene in zip(angles, scenes, strict=True)
        if (error := displacement_error(study, scene, DEFAULT, steps[0])) is not None
    ]
    best = min(sizes, key=lambda heading: heading.size) if len(sizes) > 1 else None
    worst = max(sizes, key=lambda heading: heading.size) if len(sizes) > 1 else None
    default, convergent = spreads.get(DEFAULT), spreads.get(CONVERGENT)
    return Isotropy(angles, steps[0], tuple(every), best, worst, default, convergent)


def _differs(numbers: Isotropy) -> Sequence[Claim]:
    default, convergent = numbers.default_spread, numbers.convergent_spread
    if default is None or convergent is None:
        return ()
    text = "the spread over headings, with default contacts and with convergent ones"
    return (clear(text, default, max(convergent, ALIKE_AT_ALL)),)


def loads(study: Study) -> Loads | None:
    """Normal forces at rest, while the slider moves, and with half a step of its motion allowed."""
    every = [_loads(study, method) for method in STATICS_METHODS]
    known = tuple(errors for errors in every if errors is not None)
    return Loads(known, max(errors.at_rest for errors in known)) if known else None


def _loads(study: Study, method: str) -> LoadErrors | None:
    if (run := study.recording(ExtraRun(STATICS, method, STATICS_STEP))) is None:
        return None
    exact = case(STATICS).reference.observe(run.times)
    predicted = case(STATICS).errors.at_step(scheme(method), STATICS_STEP, run.times).errors
    measured, truth, lead = (
        np.stack([source[load] for load in LOADS]) for source in (run.observables, exact, predicted)
    )
    distances = np.abs(measured / truth - 1.0).max(axis=0)
    half_step = np.abs((measured - lead) / truth - 1.0).max(axis=0)
    settled = run.times > problem(STATICS).motion.t2 + SETTLED * STATICS_STEP
    return LoadErrors(method, float(distances[settled].max()), run.times, distances, half_step)


def _statics(numbers: Loads) -> Sequence[Claim]:
    text = "the largest distance from statics at rest, relative,"
    return (at_most(text, numbers.at_rest, TRUSTED),)


CHATTER = Analysis("capsule_line/chatter", chatter, chatter_requests, _chatters)
ISOTROPY = Analysis("capsule_line/isotropy", isotropy, isotropy_requests, _differs)
LOAD_ERRORS = Analysis("capsule_line/loads", loads, load_requests, _statics)
