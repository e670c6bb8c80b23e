"""The notebook's statements on its cases, one by one, beside the exact motions."""

from __future__ import annotations

import math

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import case, convergence_of
from plumbob.reports.analyses.simple_pendulum.notebook import (
    CASES,
    DURATION,
    FINE,
    LINEAR,
    SIMPLE,
    difference,
    fine,
)

VISIBLE = 0.05  # of the amplitude: a difference that a plot shows
SETTLED = 40.0  # [s]: a forced swing, damped at 0.2/s, has forgotten its start to 2 %
MUJOCO = "mujoco/rk4"


def angle(scene: str) -> Array:
    """theta [rad] of the exact motion at FINE."""
    return fine(scene)["theta"]


def parting(name: str) -> Record:
    """The difference of the exact motions of a case."""
    apart = np.abs(difference(name))
    amplitude = abs(float(angle(SIMPLE + name)[0]))
    over = np.flatnonzero(apart > VISIBLE * amplitude)
    return Record(
        largest=apart.max(),  # difference within DURATION [rad]
        relative=apart.max() / amplitude,  # the same over the amplitude at the start
        # time of a difference of VISIBLE of the amplitude [s]
        visible_at=FINE[over[0]] if over.size else None,
    )


def swing(scene: str, since: float = 0.0) -> float:
    """Largest angle [rad] of an exact motion from a time [s] on."""
    return float(np.abs(angle(scene)[since <= FINE]).max())


def decay(name: str) -> float:
    """Largest relative difference of the extreme angles of a damped swing from |theta_0| times
    exp(-xi t/2)."""
    observed = fine(SIMPLE + name)
    rate = case(SIMPLE + name).problem
    speed = observed["theta_dot"]
    theta = observed["theta"]
    turns = np.flatnonzero(speed[:-1] * speed[1:] < 0.0)
    part = speed[turns] / (speed[turns] - speed[turns + 1])
    after = part * (FINE[1] - FINE[0])
    when = FINE[turns] + after
    # theta_dot falls linearly to zero
    sizes = np.abs(theta[turns] + 0.5 * after * speed[turns])
    expected = abs(rate.theta) * np.exp(-0.5 * rate.damping_rate * when)
    return float(np.abs(sizes / expected - 1.0).max())


def lengthening(name: str) -> float:
    """Period of a free swing over that of the linear pendulum, less 1."""
    problem = case(SIMPLE + name).problem
    natural = math.tau * math.sqrt(problem.length / problem.gravity)
    return float(problem.elliptic.period) / natural - 1.0


def rotation(name: str) -> Record:
    """A rotation, from where it starts, beside the linear pendulum."""
    problem = case(SIMPLE + name).problem
    start, end = angle(SIMPLE + name)[[0, -1]]
    least = math.sqrt(2.0 * problem.gravity / problem.length * (1.0 + math.cos(problem.theta)))
    return Record(
        turns=abs(float(end - start)) / math.tau,  # within DURATION
        linear_degrees=math.degrees(swing(LINEAR + name)),  # its largest angle [°]
        # than the speed that just reaches the top, relative
        faster=float(abs(problem.theta_dot)) / least - 1.0,
    )


def smallest_error(study: Study) -> tuple[float, float] | None:
    """The error [rad] of MuJoCo's multibody model on case 2 against the equation's solution,
    at its finest step [s]."""
    series = convergence_of(study, f"{SIMPLE}free-large", MUJOCO)
    done = [m for m in series.measurements if m.status == "done"] if series else []
    return (done[-1].errors["theta"].largest, done[-1].step) if done else None


def numbers(study: Study) -> Record:
    """The figures that the notebook's statements are held to."""
    damped = case(f"{SIMPLE}damped-small").problem
    natural = math.sqrt(damped.gravity / damped.length)
    return Record(
        partings={label: parting(CASES[label]) for label in ("1", "2", "5", "6")},
        # of the period, relative
        lengthening={label: lengthening(CASES[label]) for label in ("1", "2")},
        rotations={label: rotation(CASES[label]) for label in ("3", "4")},
        decay={label: decay(CASES[label]) for label in ("5", "6")},  # see `decay`
        # [rad], the largest angle of the forced swing, settled
        forced=swing(f"{SIMPLE}forced-large", SETTLED),
        forced_linear=swing(f"{LINEAR}forced-large", SETTLED),
        # turns, where case 7 comes to rest
        rests=float(angle(f"{SIMPLE}damped-rotating")[-1]) / math.tau,
        damping_ratio=damped.damping_rate / (2 * natural),
        mujoco=smallest_error(
            study
        ),  # error [rad] of its multibody model on case 2, at step [s]
        # non-linear less linear angle [rad] over time in case 1
        apart=(FINE[::40], difference(CASES["1"])[::40]),
        duration=DURATION,
        visible=VISIBLE,
        settled=SETTLED,
    )


CLAIMS = Analysis("simple_pendulum/notebook_claims", numbers)
