"""The notebook's statements on its cases, checked with the exact motions."""

from __future__ import annotations

import math

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import case, convergence_of
from plumbob.reports.analyses.simple_pendulum.notebook import (
    CASES,
    LINEAR_SCENES,
    NONLINEAR_SCENES,
    NOTEBOOK_DURATION,
    NOTEBOOK_TIMES,
    fine_motion,
    nonlinear_difference,
)

VISIBLE = 0.05  # difference that a plot shows, relative to the amplitude
# [s] time after which a forced swing, damped at 0.2/s, keeps 2 % of its start
SETTLING_TIME = 40.0
CLAIMS_METHOD = "mujoco/rk4"


def angle(scene: str) -> Array:
    """Returns theta [rad] of the exact motion at the times NOTEBOOK_TIMES."""
    return fine_motion(scene)["theta"]


def visible_difference(name: str) -> Record:
    """Returns the difference between the non-linear and the linear motion of a case, and the time
    at which it becomes visible."""
    differences = np.abs(nonlinear_difference(name))
    amplitude = abs(float(angle(NONLINEAR_SCENES + name)[0]))
    visible = np.flatnonzero(differences > VISIBLE * amplitude)
    return Record(
        largest=differences.max(),  # [rad] largest difference within NOTEBOOK_DURATION
        relative=differences.max()
        / amplitude,  # ratio of the largest difference to the initial amplitude
        # [s] time at which the difference exceeds VISIBLE times the amplitude
        visible_at=NOTEBOOK_TIMES[visible[0]] if visible.size else None,
    )


def largest_angle(scene: str, since: float = 0.0) -> float:
    """Returns the largest angle [rad] of an exact motion after the time `since` [s]."""
    return float(np.abs(angle(scene)[since <= NOTEBOOK_TIMES]).max())


def decay_error(name: str) -> float:
    """Returns the largest relative difference of the extreme angles of a damped swing from
    |theta_0| exp(-xi t/2)."""
    observed = fine_motion(NONLINEAR_SCENES + name)
    problem = case(NONLINEAR_SCENES + name).problem
    speed = observed["theta_dot"]
    theta = observed["theta"]
    before = np.flatnonzero(speed[:-1] * speed[1:] < 0.0)  # samples before an extreme
    # theta_dot is taken as linear between the samples around an extreme.
    fraction = speed[before] / (speed[before] - speed[before + 1])
    delay = fraction * (NOTEBOOK_TIMES[1] - NOTEBOOK_TIMES[0])
    times = NOTEBOOK_TIMES[before] + delay
    amplitudes = np.abs(theta[before] + 0.5 * delay * speed[before])
    expected = abs(problem.theta) * np.exp(-0.5 * problem.damping_rate * times)
    return float(np.abs(amplitudes / expected - 1.0).max())


def lengthening(name: str) -> float:
    """Returns the relative difference of the period of a free swing from the linear pendulum's."""
    problem = case(NONLINEAR_SCENES + name).problem
    natural = math.tau * math.sqrt(problem.length / problem.gravity)
    return float(problem.elliptic.period) / natural - 1.0


def rotation_numbers(name: str) -> Record:
    """Returns the number of turns of a rotation, the largest angle of the linear pendulum with the
    same start, and the initial speed beside the speed that just reaches the top."""
    problem = case(NONLINEAR_SCENES + name).problem
    start, end = angle(NONLINEAR_SCENES + name)[[0, -1]]
    squared = 2.0 * problem.gravity / problem.length * (1.0 + math.cos(problem.theta))
    speed_to_top = math.sqrt(squared)  # [rad/s] speed that just reaches the top
    return Record(
        turns=abs(float(end - start)) / math.tau,  # turns within NOTEBOOK_DURATION
        # [°] largest angle of the linear pendulum
        linear_degrees=math.degrees(largest_angle(LINEAR_SCENES + name)),
        # relative amount by which the initial speed exceeds the speed that just reaches the top
        faster=float(abs(problem.theta_dot)) / speed_to_top - 1.0,
    )


def smallest_error(study: Study) -> tuple[float, float] | None:
    """Returns the largest error [rad] of MuJoCo's multibody model on case 2 at its finest step, and
    that step [s]; None if MuJoCo did not run it."""
    series = convergence_of(study, f"{NONLINEAR_SCENES}free-large", CLAIMS_METHOD)
    measurements = series.measurements if series else ()
    done = [run for run in measurements if run.status == "done"]
    return (done[-1].errors["theta"].largest, done[-1].step) if done else None


def multibody_error(study: Study) -> Record:
    """Returns the error [rad] of MuJoCo's multibody model on case 2 and its step [s]."""
    return Record(mujoco=smallest_error(study))


def numbers() -> Record:
    """Returns the numbers of the exact motions that judge the notebook's statements."""
    damped = case(f"{NONLINEAR_SCENES}damped-small").problem
    natural = math.sqrt(damped.gravity / damped.length)
    return Record(
        partings={label: visible_difference(CASES[label]) for label in ("1", "2", "5", "6")},
        # relative lengthening of the period
        lengthening={label: lengthening(CASES[label]) for label in ("1", "2")},
        rotations={label: rotation_numbers(CASES[label]) for label in ("3", "4")},
        decay={label: decay_error(CASES[label]) for label in ("5", "6")},  # see `decay_error`
        # [rad] largest angle of the settled forced swing
        forced=largest_angle(f"{NONLINEAR_SCENES}forced-large", SETTLING_TIME),
        forced_linear=largest_angle(f"{LINEAR_SCENES}forced-large", SETTLING_TIME),
        # final angle of case 7 in turns
        rests=float(angle(f"{NONLINEAR_SCENES}damped-rotating")[-1]) / math.tau,
        damping_ratio=damped.damping_rate / (2 * natural),
        # times [s], and non-linear minus linear angle [rad], in case 1
        apart=(NOTEBOOK_TIMES[::40], nonlinear_difference(CASES["1"])[::40]),
        duration=NOTEBOOK_DURATION,
        visible=VISIBLE,
        settled=SETTLING_TIME,
    )


NOTEBOOK_CLAIMS = Analysis("simple_pendulum/notebook_claims", multibody_error, exact=numbers)
