"""Action and phase: I(H) and Omega(H) through the wells and across the separatrices, with periods
measured in engines; and the period of the simple pendulum against its amplitude."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.pendulums.action_curves import branches
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import AGREES, Claims, at_most
from plumbob.reports.analyses.cone_pendulum.hamiltonian import MUJOCO, ROTATING
from plumbob.reports.analyses.measurements import PERIODS, in_double, swing_period, turn_period

STEP = 2e-4  # [s]
DEEP, SHALLOW = 1.5262823409896228, -1.4708157898939431  # [rad], the wells at 26 rad/s
STARTS = (
    *((DEEP, speed) for speed in (5.0, 20.0, 33.0, 34.5, 36.0, 36.5, 40.0, 48.0, 60.0)),
    *((SHALLOW, speed) for speed in (3.0, 10.0, 13.0)),
)  # theta [rad], theta_dot [rad/s]
HIGHEST = 1100.0  # [J]
SWING, SWING_STEP = "simple-pendulum/free-large", 1e-3
AMPLITUDES = (0.3, 1.0, 2.0, 2.8, 3.1)  # [rad]
SWING_METHODS = ("mujoco/rk4", "pymunk/tight")


@cache
def started(theta: float, speed: float) -> ConePendulum:
    """The source's cone on its turning platform from another start."""
    scene = find_scene(ROTATING, {"theta": theta, "theta_dot": speed})
    return case_of(scene).problem  # type: ignore[no-any-return]


@cache
def swing_time(amplitude: float) -> float:
    """Exact period [s] of the simple pendulum with an amplitude [rad]."""
    problem = case_of(find_scene(SWING, {"theta": -amplitude})).problem
    return float(problem.elliptic.period)


def _request(theta: float, speed: float) -> ExtraRun:
    duration = PERIODS * started(theta, speed).motion.period
    return ExtraRun(ROTATING, MUJOCO, STEP, duration, (("theta", theta), ("theta_dot", speed)))


def _swing_request(method: str, amplitude: float) -> ExtraRun:
    duration = PERIODS * swing_time(amplitude)
    return ExtraRun(SWING, method, SWING_STEP, duration, (("theta", -amplitude),))


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Three periods of MuJoCo's full model from each start, and of two engines' simple pendulum."""
    return (
        *(_request(*start) for start in STARTS),
        *(_swing_request(method, size) for method in SWING_METHODS for size in AMPLITUDES),
    )


def numbers(study: Study) -> Record:
    """Actions and periods, exact and in engines' runs."""
    problem = started(DEEP, 40.0)
    close = math.pi - np.geomspace(0.14, 1e-4, 30)  # to the top
    amplitudes = np.concatenate([np.linspace(0.02, 3.0, 60), close])
    small = swing_time(1e-6)
    starts = tuple(_start(study, *start) for start in STARTS)
    gaps = (abs(start.period.gap) for start in starts if start.period.gap)
    return Record(
        starts=starts,
        # of the source's cone on its turning platform
        branches=branches(in_double(problem.potential), problem.body.inertia_x, HIGHEST),
        swings=[_swing(study, method, size) for method in SWING_METHODS for size in AMPLITUDES],
        amplitudes=amplitudes,  # [rad] of the simple pendulum
        # at them, of the exact period to that of small swings
        ratios=[swing_time(float(size)) / small for size in amplitudes],
        step=SWING_STEP,
        largest_gap=max(gaps, default=0.0),  # of a period, relative
        # largest change of an action, relative
        largest_drift=max((start.drift for start in starts if start.drift), default=0.0),
    )


def _period(exact: float, measured: float | None) -> Record:
    """A period [s], exact and measured in an engine, their relative difference, and the measured
    rate [rad/s]."""
    gap, rate = (None, None) if measured is None else (measured / exact - 1.0, math.tau / measured)
    return Record(exact=exact, measured=measured, gap=gap, rate=rate)


def _start(study: Study, theta: float, speed: float) -> Record:
    """A motion of MuJoCo's full model, from an entry of STARTS."""
    problem, run = started(theta, speed), study.answer(_request(theta, speed))
    motion, drift = problem.motion, None
    period = turn_period(run) if motion.regime == "rotation" else swing_period(run, theta)
    if run:
        system = case_of(find_scene(ROTATING)).system
        drift = float(np.abs(system.invariants(problem, run.observables)["action"]).max())
    energy, times = float(double(motion.energy)), _period(motion.period, period)
    return Record(
        theta=theta,  # [rad]
        speed=speed,  # [rad/s]
        energy=energy,  # [J]
        regime=motion.regime,
        period=times,
        drift=drift,  # largest change of the action over the run, relative
    )


def _swing(study: Study, method: str, amplitude: float) -> Record:
    """A swing of an engine's simple pendulum."""
    period = swing_period(study.answer(_swing_request(method, amplitude)), 0.0)
    ratio = None if period is None else period / swing_time(1e-6)
    return Record(
        method=method,
        amplitude=amplitude,  # [rad]
        period=_period(swing_time(amplitude), period),
        ratio=ratio,  # of the measured period to that of small swings
    )


def claims(phases: Record) -> Claims:
    """Periods are derivatives of the action, which is constant."""
    return (
        at_most(
            "the largest difference of a period, relative,", phases.largest_gap or np.nan, AGREES
        ),
        at_most(
            "the largest change of an action, relative,", phases.largest_drift or np.nan, AGREES
        ),
    )


ACTION_PHASE = Analysis("cone_pendulum/action_phase", numbers, requests, claims)
