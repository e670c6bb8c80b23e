"""Action I(H) and frequency Omega(H) in the wells and across the separatrices, and periods measured
in MuJoCo."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.pendulums.action_curves import branches
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import AGREES, Claims, at_most
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    FULL_MODEL_METHOD,
    ROTATING,
    turning_cone,
)
from plumbob.reports.analyses.measurements import MEASURED_PERIODS, in_double, period

ACTION_STEP = 2e-4  # [s]
DEEP_WELL, SHALLOW_WELL = 1.5262823409896228, -1.4708157898939431  # [rad] wells at 26 rad/s
# theta [rad], theta_dot [rad/s]
WELLS_AND_SPEEDS = (
    *((DEEP_WELL, speed) for speed in (5.0, 20.0, 33.0, 34.5, 36.0, 36.5, 40.0, 48.0, 60.0)),
    *((SHALLOW_WELL, speed) for speed in (3.0, 10.0, 13.0)),
)
HIGHEST = 1100.0  # [J] highest energy of the curves


def _request(theta: float, speed: float) -> ExtraRun:
    """Returns MuJoCo's run over MEASURED_PERIODS periods from a start (`theta` [rad], `speed`
    [rad/s])."""
    duration = MEASURED_PERIODS * turning_cone(theta=theta, theta_dot=speed).motion.period
    return ExtraRun(
        ROTATING,
        FULL_MODEL_METHOD,
        ACTION_STEP,
        duration,
        (("theta", theta), ("theta_dot", speed)),
    )


def numbers(study: Study) -> Record:
    """Returns actions and periods, exact and in MuJoCo's runs."""
    problem = turning_cone(theta=DEEP_WELL, theta_dot=40.0)
    starts = tuple(_motion_from(study, *start) for start in WELLS_AND_SPEEDS)
    gaps = [abs(start.gap) for start in starts if start.gap]
    drifts = [start.drift for start in starts if start.drift]
    return Record(
        starts=starts,
        # curves of action and frequency for the source's cone on its turning platform
        branches=branches(in_double(problem.potential), problem.body.inertia_x, HIGHEST),
        largest_gap=max(gaps, default=0.0),  # largest relative error of a period
        largest_drift=max(drifts, default=0.0),  # largest relative change of an action
    )


def _motion_from(study: Study, theta: float, speed: float) -> Record:
    """Returns energy, period and drift of the action for one start (`theta` [rad], `speed`
    [rad/s]), exact and in a run of MuJoCo's full model."""
    problem = turning_cone(theta=theta, theta_dot=speed)
    run = study.answer(_request(theta, speed))
    motion = problem.motion
    drift = None
    measured = period(run, theta)
    if run:
        system = case_of(find_scene(ROTATING)).system
        drift = float(np.abs(system.invariants(problem, run.observables)["action"]).max())
    return Record(
        theta=theta,  # [rad]
        speed=speed,  # [rad/s]
        energy=double(motion.energy),  # [J]
        regime=motion.regime,
        period=motion.period,  # [s]
        measured=measured,  # [s] period in MuJoCo
        gap=None if measured is None else measured / motion.period - 1.0,  # relative error
        drift=drift,  # largest relative change of the action over the run
    )


def claims(phases: Record) -> Claims:
    """Returns the checks that MuJoCo's periods agree with the derivatives of the action, and that
    the action is constant."""
    gap = phases.largest_gap or np.nan
    drift = phases.largest_drift or np.nan
    return (
        at_most("the largest difference of a period, relative,", gap, AGREES),
        at_most("the largest change of an action, relative,", drift, AGREES),
    )


ACTION_PHASE = Analysis(
    "cone_pendulum/action_phase",
    numbers,
    lambda plan: tuple(_request(*start) for start in WELLS_AND_SPEEDS),
    claims,
)
