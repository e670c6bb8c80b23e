"""The notebook's statements on its cases, one by one, beside the exact motions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.measurements import case, convergence_of, largest
from plumbob.reports.analyses.simple_pendulum.notebook import (
    CASES,
    DURATION,
    LINEAR,
    SIMPLE,
    at_every_step,
    difference,
    own_run,
    requests,
)

TIMES = np.linspace(0.0, DURATION, 5001)  # [s], 200 in a period
SEEN = 0.05  # of the amplitude: a difference that a plot shows
SETTLED = 40.0  # [s]: a forced swing, damped at 0.2/s, has forgotten its start to 2 %
MUJOCO = "mujoco/rk4"


@dataclass(frozen=True)
class Parting:
    """How the linear motion of a case leaves the non-linear one."""

    largest: float  # difference within DURATION [rad]
    relative: float  # the same over the amplitude at the start
    seen: float | None  # time of a difference of SEEN of the amplitude [s]
    in_runs: float | None  # the largest difference in the notebook's own RK4 [rad]


@dataclass(frozen=True)
class Rotation:
    """A rotation beside the swing of the linear pendulum from the same start."""

    turns: float  # within DURATION
    linear_degrees: float  # its largest angle [°]
    faster: float  # than the speed that just reaches the top, relative


@dataclass(frozen=True)
class Ahead:
    """Non-linear less linear angle [rad] over time [s]."""

    times: Array
    angles: Array


@dataclass(frozen=True)
class SmallestError:
    """The error [rad] of an engine at its finest step [s]."""

    error: float
    step: float


@dataclass(frozen=True)
class NotebookClaims:
    """The figures that the notebook's statements are held to, of cases by their labels."""

    partings: Mapping[str, Parting]
    lengthening: Mapping[str, float]  # of the period, relative
    rotations: Mapping[str, Rotation]
    decay: Mapping[str, float]  # see `decay`
    forced: float  # [rad], the largest angle of the forced swing, settled
    forced_linear: float
    rests: float  # turns, where case 7 comes to rest
    damping_ratio: float
    mujoco: SmallestError | None  # of its multibody model on case 2
    exact: Ahead  # in case 1
    by_rk4: Ahead | None
    duration: float = DURATION
    seen: float = SEEN
    settled: float = SETTLED


def angle(scene: str) -> Array:
    """theta [rad] of the exact motion at TIMES."""
    return case(scene).reference.observe(TIMES)["theta"]


def parting(study: Study, name: str) -> Parting:
    """The difference of the exact motions of a case, and of the notebook's own runs of it."""
    amplitude = abs(float(angle(SIMPLE + name)[0]))
    over = np.flatnonzero(np.abs(difference(TIMES, name)) > SEEN * amplitude)
    most = largest(partial(difference, name=name), TIMES)
    runs = runs_apart(study, name)
    in_runs = None if runs is None else float(np.abs(at_every_step(*runs)).max())
    return Parting(most, most / amplitude, float(TIMES[over[0]]) if over.size else None, in_runs)


def runs_apart(study: Study, name: str) -> tuple[Array, Array, Array] | None:
    """Times [s] of the notebook's own runs of a case, and the non-linear theta [rad] and theta_dot
    [rad/s] less the linear ones."""
    pendulum, linear = (study.recording(own_run(kind + name)) for kind in (SIMPLE, LINEAR))
    if pendulum is None or linear is None:
        return None
    theta, rate = (pendulum.observables[n] - linear.observables[n] for n in ("theta", "theta_dot"))
    return pendulum.times, theta, rate


def swing(scene: str, times: Array = TIMES) -> float:
    """Largest angle [rad] of an exact motion from the first to the last of `times` [s]."""
    return largest(lambda t: case(scene).reference.observe(t)["theta"], times)


def decay(name: str) -> float:
    """Largest relative difference of the extreme angles of a damped swing from |theta_0| times
    exp(-xi t/2)."""
    observed, rate = case(SIMPLE + name).reference.observe(TIMES), case(SIMPLE + name).problem
    speed, theta = observed["theta_dot"], observed["theta"]
    turns = np.flatnonzero(speed[:-1] * speed[1:] < 0.0)
    part = speed[turns] / (speed[turns] - speed[turns + 1])
    after = part * (TIMES[1] - TIMES[0])
    when = TIMES[turns] + after
    sizes = np.abs(theta[turns] + 0.5 * after * speed[turns])  # theta_dot falls linearly to zero
    expected = abs(rate.theta) * np.exp(-0.5 * rate.damping_rate * when)
    return float(np.abs(sizes / expected - 1.0).max())


def forced(name: str) -> tuple[float, float]:
    """Largest angles [rad] of the pendulum and of the linear one after SETTLED."""
    nonlinear, linear = (swing(kind + name, TIMES[TIMES >= SETTLED]) for kind in (SIMPLE, LINEAR))
    return nonlinear, linear


def lengthening(name: str) -> float:
    """Period of a free swing over that of the linear pendulum, less 1."""
    problem = case(SIMPLE + name).problem
    natural = math.tau * math.sqrt(problem.length / problem.gravity)
    return float(problem.elliptic.period) / natural - 1.0


def rotation(name: str) -> Rotation:
    """A rotation, from where it starts, beside the linear pendulum."""
    problem = case(SIMPLE + name).problem
    start, end = angle(SIMPLE + name)[[0, -1]]
    least = math.sqrt(2.0 * problem.gravity / problem.length * (1.0 + math.cos(problem.theta)))
    return Rotation(
        abs(float(end - start)) / math.tau,
        math.degrees(swing(LINEAR + name)),
        float(abs(problem.theta_dot)) / least - 1.0,
    )


def smallest_error(study: Study) -> SmallestError | None:
    """The error of MuJoCo's multibody model on case 2 against the equation's solution."""
    series = convergence_of(study, f"{SIMPLE}free-large", MUJOCO)
    done = [m for m in series.measurements if m.status == "done"] if series else []
    return SmallestError(done[-1].errors["theta"].largest, done[-1].step) if done else None


def numbers(study: Study) -> NotebookClaims:
    """The figures that the notebook's statements are held to."""
    damped, runs = case(f"{SIMPLE}damped-small").problem, runs_apart(study, CASES["1"])
    natural = math.sqrt(damped.gravity / damped.length)
    return NotebookClaims(
        {label: parting(study, CASES[label]) for label in ("1", "2", "5", "6")},
        {label: lengthening(CASES[label]) for label in ("1", "2")},
        {label: rotation(CASES[label]) for label in ("3", "4")},
        {label: decay(CASES[label]) for label in ("5", "6")},
        *forced("forced-large"),
        float(angle(f"{SIMPLE}damped-rotating")[-1]) / math.tau,
        damped.damping_rate / (2 * natural),
        smallest_error(study),
        Ahead(TIMES[::10], difference(TIMES, CASES["1"])[::10]),
        None if runs is None else Ahead(runs[0][::5], runs[1][::5]),
    )


CLAIMS = Analysis("simple_pendulum/notebook_claims", numbers, requests)
