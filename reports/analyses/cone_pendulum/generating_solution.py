"""The exact motion as a generating solution: a weakly damped axle, a drive that is not ideal."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from plumbob.analytic.errors.contact_models.driven_platform import drive_error
from plumbob.analytic.systems.pendulums.slow_change import DampedRotation, action_and_phase
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, at_most
from plumbob.reports.analyses.cone_pendulum.action_phase import started
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    MUJOCO,
    MUJOCO_STEP,
    ROTATING,
    forms,
)
from plumbob.reports.analyses.measurements import in_double

SPEED = 60.0  # [rad/s], from theta = 0: half of the action is left when it comes to the barrier
WITHIN = 1e-2  # of the action: what first-order averaging leaves
DECAY = 0.16  # xi times the duration: what the action falls by
STEP = 2e-4
TURNS = MappingProxyType({"quick": 65.0, "full": 1100.0})  # of the damped rotation
INERTIAS = (1e3, 1e4, 1e5)  # [kg m^2] of the platform
OWN = 1.0  # [kg m^2] of the platform in the model's file, beside it
DRIVE_RATE, DRIVE_TIME = 5.0, 2.0  # [1/s], [s]
PLACES = 12  # of a run that are looked at


def damped(turns: float) -> ExtraRun:
    """A rotation with a damped axle, as long as so many undamped turns."""
    duration = turns * started(0.0, SPEED).motion.period
    settings = (("axle_damping_rate", DECAY / duration),)
    return ExtraRun(ROTATING, MUJOCO, STEP, duration, (("theta_dot", SPEED),), settings)


def _drive(inertia: float) -> ExtraRun:
    settings = (("platform_armature", inertia), ("drive_rate", DRIVE_RATE))
    return ExtraRun(ROTATING, MUJOCO, MUJOCO_STEP, DRIVE_TIME, (), settings)


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """A damped rotation, over a thousand turns in the full profile; platforms with weak drives."""
    return (damped(TURNS[plan.profile]), *map(_drive, INERTIAS))


def averaged(run: Trajectory) -> Record:
    """The action and the phase of a damped run at PLACES of its samples, beside averaging."""
    problem, data, last = started(0.0, SPEED), run.observables, float(run.times[-1])
    xi = DECAY / last
    rule = DampedRotation(in_double(problem.potential), problem.body.inertia_x, SPEED, xi)
    kept = np.linspace(0, len(run.times) - 1, PLACES + 1).astype(int)[1:]
    states = zip(data["theta"][kept], data["theta_dot"][kept], strict=True)
    pairs = [action_and_phase(rule.potential, rule.inertia, *map(float, state)) for state in states]
    actions, phases = np.array(pairs).T
    return Record(
        xi=xi,  # [1/s]
        turns=phases[-1] / (2 * np.pi),
        gap=np.abs(actions / rule.action(run.times[kept]) - 1.0).max(),  # of the action, relative
        phase_gap=phases[-1] - rule.phase(last),  # [rad], at the end
    )


def _driven(run: Trajectory, inertia: float) -> Record:
    """How far theta leaves the ideal motion by the end of a run with a weak drive."""
    problem = forms(ROTATING).problem
    # the servo's gain is DRIVE_RATE times the armature, and moves the platform's own too
    rate = DRIVE_RATE * inertia / (inertia + OWN)
    first = drive_error(problem, run.times, inertia + OWN, rate).theta[-1]
    apart = (run.observables["theta"] - problem.reference.state(run.times)[0])[-1]
    return Record(
        inertia=inertia,  # [kg m^2] of the platform
        apart=apart,  # [rad]
        first=first,  # the same, predicted to first order
        gap=apart / first - 1.0,  # relative
    )


def numbers(study: Study) -> Record:
    """Averaging against many turns, and first-order perturbation against a weak drive."""
    run = study.answer(damped(TURNS[study.profile]))
    runs = [(study.answer(_drive(inertia)), inertia) for inertia in INERTIAS]
    return Record(
        damped=averaged(run) if run else None,
        drives=[_driven(run, inertia) for run, inertia in runs if run],
        drive_rate=DRIVE_RATE,
        drive_time=DRIVE_TIME,
    )


def claims(solutions: Record) -> Claims:
    """The action falls as averaging has it."""
    what = "the largest difference of an action from the averaged one, relative,"
    return (at_most(what, solutions.damped.gap, WITHIN),) if solutions.damped else ()


GENERATING_SOLUTION = Analysis("cone_pendulum/generating_solution", numbers, requests, claims)
