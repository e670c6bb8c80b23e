"""The notebook's seven cases: its plots beside the exact motions, and the errors of its method."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import product
from types import MappingProxyType

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims
from plumbob.reports.analyses.measurements import case, scheme
from plumbob.reports.records.claim import Claim
from plumbob.reports.records.notation import number

NONLINEAR_SCENES, LINEAR_SCENES = "simple-pendulum/", "linear-pendulum/"
# [s] method of the notebook, with 1000 steps
NOTEBOOK_METHOD, NOTEBOOK_STEP, NOTEBOOK_DURATION = "ode/rk4", 0.05, 50.0
EVERY_STEP = np.linspace(0.0, NOTEBOOK_DURATION, 1001)  # [s]
# [s] fine enough to know a maximum to 1e-5 of it
NOTEBOOK_TIMES = np.linspace(0.0, NOTEBOOK_DURATION, 20_001)
# [s] duration in the phase plane, where more than a few swings hide each other
PHASE_PLANE_DURATION = 15.0
STEPS_PER_DOT = 8  # steps from one dot to the next, 0.4 s
CASES = MappingProxyType(
    {
        "1": "free-small",
        "2": "free-large",
        "3": "rotating-slow",
        "4": "rotating-fast",
        "5": "damped-small",
        "6": "damped-large",
        "7": "damped-rotating",
    }
)


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Returns the notebook's run of each case, non-linear and linear."""
    pairs = product(CASES.values(), (NONLINEAR_SCENES, LINEAR_SCENES))
    return [notebook_run(kind + name) for name, kind in pairs]


def notebook_run(scene: str) -> ExtraRun:
    """Returns the notebook's run of a scene: its method, step and duration."""
    return ExtraRun(scene, NOTEBOOK_METHOD, NOTEBOOK_STEP, NOTEBOOK_DURATION)


def cases(study: Study) -> Record:
    """Returns theta(t) and the phase-plane curves of each case, linear and non-linear, exact and by
    RK4."""
    motions = []
    for label, name in CASES.items():
        pendulum = _motions(study, NONLINEAR_SCENES + name)
        linear = _motions(study, LINEAR_SCENES + name)
        motions.append(Record(label=label, pendulum=pendulum, linear=linear))
    return Record(
        cases=motions,
        shown=PHASE_PLANE_DURATION,
        duration=NOTEBOOK_DURATION,
        dots=NOTEBOOK_STEP * STEPS_PER_DOT,  # [s]
    )


def _motions(study: Study, scene: str) -> tuple[Record, Record | None]:
    """Returns the curves of a scene's exact motion and of the notebook's run; None for a missing
    run."""
    observed = case(scene).reference.observe(EVERY_STEP)
    exact = _curves(EVERY_STEP, observed["theta"], observed["theta_dot"])
    run = study.answer(notebook_run(scene))
    if run is None:
        return exact, None
    theta = run.observables["theta"]
    rate = run.observables["theta_dot"]
    return exact, _curves(
        run.times[::STEPS_PER_DOT], theta[::STEPS_PER_DOT], rate[::STEPS_PER_DOT]
    )


def _curves(times: Array, theta: Array, rate: Array) -> Record:
    """Returns the curves of a motion over time and in the phase plane, in degrees."""
    degrees = np.degrees(theta)
    rate_degrees = np.degrees(rate)
    shown = times <= PHASE_PLANE_DURATION
    return Record(
        over_time=(times, degrees),
        in_plane=(degrees[shown], rate_degrees[shown]),
    )


def notebook_errors(study: Study) -> Record:
    """Returns the errors of RK4 in each case, at dt 0.05 over a thousand steps."""
    entries = []
    for label, name in CASES.items():
        measured, predicted = rk4_error(study, NONLINEAR_SCENES + name)
        entry = Record(
            label=label,
            scene=name,
            error=measured,  # [rad] largest error of RK4
            predicted=predicted,  # [rad]
            # [rad] RK4 on the linear pendulum
            of_linear=rk4_error(study, LINEAR_SCENES + name)[0],
        )
        entries.append(entry)
    sizes = [entry.error for entry in entries]
    ratio = max(sizes) / min(sizes)
    return Record(cases=entries, factor=round(ratio, -2))  # ratio rounded to hundreds


def linear_errors() -> Record:
    """Returns the error of the linear equation in each case: the largest difference [rad] of its
    motion from the non-linear one."""
    by_case = {label: np.abs(nonlinear_difference(n)).max() for label, n in CASES.items()}
    return Record(differences=by_case)


def claims(errors: Record) -> Claims:
    """Returns the checks that, in each case, the error of the linear equation exceeds RK4's."""
    checks = []
    for entry in errors.cases:
        difference = errors.differences[entry.label]
        text = (
            f"in case {entry.label} the error of RK4 is {number(entry.error)} rad, of the linear "
            f"equation {number(difference)} rad"
        )
        # written so that an error that is not a number passes: its run was not made
        checks.append(Claim(text, not entry.error >= difference))
    return checks


def rk4_error(study: Study, scene: str) -> tuple[float, float | None]:
    """Returns the largest error [rad] of the notebook's run at any step, and the predicted largest
    error [rad]; NaN and None if the run is missing."""
    run = study.answer(notebook_run(scene))
    if run is None:
        return float("nan"), None
    exact = case(scene).reference.observe(run.times)
    theta_error = run.observables["theta"] - exact["theta"]
    rate_error = run.observables["theta_dot"] - exact["theta_dot"]
    errors = angles_at_every_step(run.times, theta_error, rate_error)
    predictor = case(scene).errors
    predicted = predictor.at_step(scheme(NOTEBOOK_METHOD), NOTEBOOK_STEP, EVERY_STEP).errors[
        "theta"
    ]
    return float(np.abs(errors).max()), float(np.abs(predicted).max())


def angles_at_every_step(times: Array, theta: Array, rate: Array) -> Array:
    """Returns the angles [rad] after each step of a notebook's run, shape (1001,).

    A recording has every second step: angles `theta` [rad] and rates `rate` [rad/s] at `times` [s].
    A cubic through these gives the steps between."""
    from scipy.interpolate import CubicHermiteSpline

    return CubicHermiteSpline(times, theta, rate)(EVERY_STEP)


@cache
def fine_motion(scene: str) -> Signals:
    """Returns the exact motion of a scene at the times NOTEBOOK_TIMES; cached for all findings."""
    return case(scene).reference.observe(NOTEBOOK_TIMES)


def nonlinear_difference(name: str) -> Array:
    """Returns the non-linear minus the linear angle [rad] of a case's exact motions at the times
    NOTEBOOK_TIMES, shape (n,)."""
    return (
        fine_motion(NONLINEAR_SCENES + name)["theta"]
        - fine_motion(LINEAR_SCENES + name)["theta"]
    )


CASE_MOTIONS = Analysis("simple_pendulum/notebook_cases", cases, requests)
NOTEBOOK_RK4 = Analysis(
    "simple_pendulum/notebook_rk4", notebook_errors, requests, claims, linear_errors
)
