"""The exact motion as a generating solution: a weakly damped axle, a drive that is not ideal."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from plumbob.analytic.errors.contact_models.driven_platform import drive_error
from plumbob.analytic.systems.pendulums.slow_change import DampedRotation, action_and_phase
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.request import Changes
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, at_most
from plumbob.reports.analyses.cone_pendulum.action_phase import started
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    LAGRANGE,
    MUJOCO,
    MUJOCO_STEP,
    ROTATING,
    forms,
)
from plumbob.reports.analyses.measurements import in_double

SPEED = 60.0  # [rad/s], from theta = 0: half of the action is left when it comes to the barrier
WITHIN = 1e-2  # of the action: what first-order averaging leaves
DECAY = 0.16  # xi times the duration: what the action falls by
STEP, TOLERANCE = 2e-4, 1e-11
TURNS = (("quick", 65.0), ("full", 1100.0))  # of the longest run of a profile
INERTIAS = (1e3, 1e4, 1e5)  # [kg m^2] of the platform
OWN = 1.0  # [kg m^2] of the platform in the model's file, beside it
DRIVE_RATE, DRIVE_TIME = 5.0, 2.0  # [1/s], [s]
PLACES = 12  # of a run that are looked at


def _durations(profile: str) -> tuple[float, ...]:
    """The durations [s] of a profile's damped rotations, each with half the damping of the one
    before."""
    longest = dict(TURNS)[profile] * started(0.0, SPEED).motion.period
    return longest / 4, longest / 2, longest


def _methods(profile: str) -> tuple[str, ...]:
    return (MUJOCO, LAGRANGE) if profile == "full" else (MUJOCO,)


def _damped(method: str, duration: float) -> ExtraRun:
    step = TOLERANCE if method == LAGRANGE else STEP
    settings: Changes = (("axle_damping_rate", DECAY / duration),)
    return ExtraRun(ROTATING, method, step, duration, (("theta_dot", SPEED),), settings)


def _drive(inertia: float) -> ExtraRun:
    settings: Changes = (("platform_armature", inertia), ("drive_rate", DRIVE_RATE))
    return ExtraRun(ROTATING, MUJOCO, MUJOCO_STEP, DRIVE_TIME, (), settings)


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Damped rotations, over a thousand turns in the full profile; platforms with weak drives."""
    return (
        *(_damped(m, t) for t in _durations(plan.profile) for m in _methods(plan.profile)),
        *(_drive(inertia) for inertia in INERTIAS),
    )


@cache
def averaged(xi: float) -> DampedRotation:
    """The averaged motion of the source's cone with a damped axle."""
    problem = started(0.0, SPEED)
    return DampedRotation(in_double(problem.potential), problem.body.inertia_x, SPEED, xi)


def _damped_run(run: Trajectory, method: str, xi: float) -> Record:
    """The action and the phase of a run at PLACES of its samples."""
    rule, data = averaged(xi), run.observables
    kept = np.linspace(0, len(run.times) - 1, PLACES + 1).astype(int)[1:]
    states = zip(data["theta"][kept], data["theta_dot"][kept], strict=True)
    pairs = [action_and_phase(rule.potential, rule.inertia, *map(float, state)) for state in states]
    times, (actions, phases) = run.times[kept], np.array(pairs).T
    gap = float(np.abs(actions / rule.action(times) - 1.0).max())
    phase_gap = float(phases[-1] - rule.phase(float(times[-1])))
    return Record(
        method=method,
        xi=xi,  # [1/s]
        times=times,  # [s]
        actions=actions,  # [J s]
        turns=phases[-1] / (2 * np.pi),
        gap=gap,  # largest difference of an action, relative
        phase_gap=phase_gap,  # [rad], at the end
    )


def _drive_run(run: Trajectory, inertia: float) -> Record:
    """How far theta leaves the ideal motion in a run with a weak drive."""
    problem = forms(ROTATING).problem
    # the servo's gain is DRIVE_RATE times the armature, and moves the platform's own too
    rate = DRIVE_RATE * inertia / (inertia + OWN)
    first = drive_error(problem, run.times, inertia + OWN, rate).theta
    apart = run.observables["theta"] - problem.reference.state(run.times)[0]
    return Record(
        inertia=inertia,  # [kg m^2] of the platform
        times=run.times,  # [s]
        apart=apart,  # [rad]
        first=first,  # the same, predicted to first order
        gap=apart[-1] / first[-1] - 1.0,  # relative, at the end
        scaled=(apart * inertia, first * inertia),
    )


def numbers(study: Study) -> Record:
    """Averaging against a thousand turns, and first-order perturbation against a weak drive."""
    durations = _durations(study.profile)
    damped = tuple(
        _damped_run(run, method, DECAY / duration)
        for duration in durations
        for method in _methods(study.profile)
        if (run := study.answer(_damped(method, duration)))
    )
    drives = tuple(
        _drive_run(run, inertia) for inertia in INERTIAS if (run := study.answer(_drive(inertia)))
    )
    xi, times = DECAY / durations[-1], np.linspace(0.0, durations[-1], 61)
    return Record(
        damped=damped,
        drives=drives,
        xi=xi,  # [1/s] of the longest damped rotation
        times=times,  # [s]
        actions=averaged(xi).action(times),  # [J s] of that at them, averaged
        speed=SPEED,
        drive_rate=DRIVE_RATE,
        drive_time=DRIVE_TIME,
        # largest difference of an action from the averaged one, relative
        largest_gap=max((run.gap for run in damped), default=0.0),
        # largest difference of a phase at the end [rad]
        largest_phase_gap=max((abs(run.phase_gap) for run in damped), default=0.0),
        turns=max((run.turns for run in damped), default=0.0),  # of the longest run
    )


def claims(solutions: Record) -> Claims:
    """The action falls as averaging has it."""
    what = "the largest difference of an action from the averaged one, relative,"
    return (at_most(what, solutions.largest_gap, WITHIN),)


GENERATING_SOLUTION = Analysis("cone_pendulum/generating_solution", numbers, requests, claims)
