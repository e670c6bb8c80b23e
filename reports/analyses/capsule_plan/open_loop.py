"""Plans run open-loop in engines: the pose's error at the end, by what caused it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.capsule_plan.plans import (
    SHOWN,
    PlanNumbers,
    names,
    plan_numbers,
    plan_of,
)
from plumbob.reports.analyses.capsule_plan.pose_errors import (
    PoseError,
    PoseErrors,
    by_kind,
    errors_of,
    run_of,
)

DEFAULT = "mujoco/euler"  # its contacts' stiction drifts
METHODS = ("mujoco/euler+coulomb", "pymunk/feet", "mujoco/rk4+coulomb", DEFAULT)
QUICK = METHODS[:2]
STEP = 1e-3  # [s]
SMALLEST = 1e-12  # [m] and [rad]: where an error of zero is drawn


@dataclass(frozen=True)
class Ended:
    """The error of a plan's end, and the part of it that each kind of manoeuvre caused."""

    scene: str
    method: str
    distance: float  # [m]
    heading: float  # [rad]
    parts: Mapping[str, PoseError]


@dataclass(frozen=True)
class Span:
    """The error of the place at the end of a method's plans [m]."""

    method: str
    plans: int
    least: float
    largest: float


@dataclass(frozen=True)
class Course:
    """The error after each manoeuvre at whose end the body is at rest."""

    method: str
    times: tuple[float, ...]  # [s]
    kinds: tuple[str, ...]
    distances: tuple[float, ...]  # [m]
    headings: tuple[float, ...]  # [rad]


@dataclass(frozen=True)
class OpenLoop:
    """Plans of a study, run open-loop to their ends."""

    first: PlanNumbers
    ends: tuple[Ended, ...]
    spans: tuple[Span, ...]
    slow: float | None  # [m]: slow motions' largest error with friction that converges
    slow_default: float | None  # and on default contacts
    shown: str  # the plan of `courses`; empty where the study lacks it
    courses: tuple[Course, ...]
    step: float = STEP
    quick: tuple[str, ...] = QUICK


def methods(study: Study | StudyPlan) -> tuple[str, ...]:
    """The methods that run plans open-loop."""
    return METHODS if study.profile == "full" else QUICK


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Each plan of the study, run open-loop to its end."""
    return [run_of(name, method, STEP) for name in names(plan) for method in methods(plan)]


def numbers(study: Study) -> OpenLoop | None:
    """The errors at the end by plan and method; None without a plan or an engine."""
    every = [
        (name, method, errors)
        for name in names(study)
        for method in methods(study)
        if (errors := errors_of(study, name, method, STEP)) is not None
    ]
    ends = tuple(end for run in every if (end := _ended(*run)) is not None)
    if not ends:
        return None
    shown = SHOWN if SHOWN in names(study) else ""
    return OpenLoop(
        plan_numbers(plan_of(names(study)[0])),
        ends,
        tuple(_span(method, ends) for method in dict.fromkeys(end.method for end in ends)),
        _slow([end for end in ends if end.method != DEFAULT]),
        _slow([end for end in ends if end.method == DEFAULT]),
        shown,
        tuple(_course(shown, method, errors) for name, method, errors in every if name == shown),
    )


def _ended(name: str, method: str, errors: PoseErrors) -> Ended | None:
    if (last := errors[-1]) is None:
        return None
    return Ended(name, method, last.distance, last.heading, by_kind(plan_of(name), errors))


def _span(method: str, ends: Sequence[Ended]) -> Span:
    distances = [end.distance for end in ends if end.method == method]
    return Span(method, len(distances), min(distances), max(distances))


def _slow(ends: Sequence[Ended]) -> float | None:
    """The largest part of an error that slow motions caused [m]."""
    return max((end.parts["slow"].distance for end in ends if "slow" in end.parts), default=None)


def _course(name: str, method: str, errors: PoseErrors) -> Course:
    plan = plan_of(name)
    resting = [
        (
            float(end),
            manoeuvre.kind,
            max(error.distance, SMALLEST),
            max(abs(error.heading), SMALLEST),
        )
        for end, manoeuvre, error in zip(plan.ends, plan.manoeuvres, errors, strict=True)
        if error is not None
    ]
    return Course(method, *zip(*resting, strict=True))


OPEN_LOOP = Analysis("capsule_plan/open_loop", numbers, requests)
