"""Figs. 2 and 3 of the source, panels a to e: printed curves, corrected curves and MuJoCo's
runs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    FULL_MODEL_METHOD,
    FULL_MODEL_STEP,
    RESTING,
    ROTATING,
    closed_forms,
)
from plumbob.reports.analyses.measurements import in_double

PLATFORM_TURN = 2 * np.pi
RUN_MARKS = 40  # marks of the engine's run over one period
FIGURE_POINTS = 241  # points of a curve
TEMPLATE = "cone_pendulum/source_figures"
# x and y of the curves by panel, a to e; angles are divided by 2 pi, and times by the period T
Curves = Mapping[str, tuple[Array, Array]]


def _one_period(scene: str) -> ExtraRun:
    """Returns MuJoCo's run of a scene over one period."""
    return ExtraRun(
        scene, FULL_MODEL_METHOD, FULL_MODEL_STEP, closed_forms(scene).correct.period
    )


def numbers(study: Study) -> Record:
    """Returns the curves of Fig. 2, on a resting base, and of Fig. 3, on a turning base."""
    return Record(
        cases={
            "resting": _panels(RESTING, study.answer(_one_period(RESTING))),
            "rotating": _panels(ROTATING, study.answer(_one_period(ROTATING))),
        }
    )


def _panels(scene: str, run: Trajectory | None) -> Record:
    """Returns the panels of one case: the corrected motion, the printed motion and MuJoCo's run."""
    correct = closed_forms(scene).correct
    printed = closed_forms(scene).printed
    return Record(
        corrected=_curves(correct),
        printed=_curves(printed),
        mujoco={} if run is None else _marks(run, correct),  # empty without a run
    )


def _curves(motion: PendulumMotion) -> Record:
    """Returns the five curves of a rotation."""
    period = motion.period
    theta = np.linspace(0.0, PLATFORM_TURN, FIGURE_POINTS)
    times = np.linspace(0.0, period, FIGURE_POINTS)
    angle = theta / PLATFORM_TURN
    time = times / period
    rate = motion.state(times)[1]
    return Record(
        period=period,  # [s]
        barrier=double(motion.barriers[0]),  # [J] maximum of V
        energy=double(motion.energy),  # [J]
        curves={
            "a": (angle, in_double(motion.potential).value(theta)),
            "b": (angle, motion.time_at(theta) / period),
            "c": (angle, motion.momentum(theta)),
            "d": (time, motion.inertia * rate),
            "e": (time, rate),
        },
    )


def _marks(run: Trajectory, motion: PendulumMotion) -> Curves:
    """Returns the marks of a run in panels b to e, at a few samples."""
    samples = np.unique(np.linspace(0, len(run.times) - 1, RUN_MARKS).astype(int))
    angle = run.observables["theta"][samples] / PLATFORM_TURN
    time = run.times[samples] / motion.period
    rate = run.observables["theta_dot"][samples]
    momentum = motion.inertia * rate
    return {
        "b": (angle, time),
        "c": (angle, momentum),
        "d": (time, momentum),
        "e": (time, rate),
    }


GALLERIES = Analysis(
    TEMPLATE, numbers, lambda plan: tuple(map(_one_period, (RESTING, ROTATING)))
)
