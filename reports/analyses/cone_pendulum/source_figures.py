"""Figs. 2 and 3 of the source, a to e: the printed curves, the corrected ones, and MuJoCo's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.analytic.systems.pendulums.tilted_motion import TiltedMotion
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    MUJOCO,
    MUJOCO_STEP,
    RESTING,
    ROTATING,
    forms,
)
from plumbob.reports.analyses.measurements import in_double

TURN = 2 * np.pi
DOTS = 40  # of the engine's run, over one period
POINTS = 241  # of a curve
TEMPLATE = "cone_pendulum/source_figures"
Curves = Mapping[str, tuple[Array, Array]]  # of panels a to e: angles over 2 pi or times over T


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """A period of MuJoCo's full model on either base."""
    return tuple(_period(scene) for scene in (RESTING, ROTATING))


def _period(scene: str) -> ExtraRun:
    return ExtraRun(scene, MUJOCO, MUJOCO_STEP, forms(scene).correct.period)


def numbers(study: Study) -> Record:
    """Fig. 2, on a resting base, and Fig. 3, on a turning one."""
    return Record(
        cases={
            "resting": _panels(forms(RESTING).problem, study.answer(_period(RESTING))),
            "rotating": _panels(forms(ROTATING).problem, study.answer(_period(ROTATING))),
        }
    )


def solved(case: Case) -> Record:
    """The same for any parameters."""
    return Record(cases={"case": _panels(case.problem.started, None)})


def _panels(problem: ConePendulum, run: Trajectory | None) -> Record:
    """The panels of one case: the corrected motion, the printed one, and MuJoCo's run."""
    right, printed = problem.motion, problem.printed_motion()
    theta = np.linspace(0.0, TURN, POINTS)
    wells = problem.potential_at(theta), np.asarray(in_double(printed.potential).value(theta))
    return Record(
        corrected=_drawn(problem.reference, right, wells[0], problem.potential_offset),
        printed=_drawn(printed, printed, wells[1]),
        mujoco={} if run is None else _sampled(run, right),  # empty where there is none
    )


def _drawn(
    motion: PendulumMotion | TiltedMotion, principal: PendulumMotion, well: Array, offset: float = 0
) -> Record:
    """A motion of which the `principal` one, less `offset` [J], has the period and the barrier."""
    period = principal.period
    span = period if np.isfinite(period) else 1.0  # on a separatrix, and at rest, seconds
    theta, times = np.linspace(0.0, TURN, POINTS), np.linspace(0.0, span, POINTS)
    angle, time = theta / TURN, times / span
    rate = motion.state(times)[1]
    tops = principal.barriers
    return Record(
        period=period,  # [s]
        barrier=float(double(tops[0])) + offset if tops.size else well.max(),  # top of V [J]
        energy=float(double(principal.energy)) + offset,  # [J]
        curves={
            "a": (angle, well),
            "b": (angle, motion.time_at(theta) / span),
            "c": (angle, motion.momentum(theta)),
            "d": (time, principal.inertia * rate),
            "e": (time, rate),
        },
    )


def _sampled(run: Trajectory, motion: PendulumMotion) -> Curves:
    """Panels b to e of a few samples of a run."""
    kept = np.unique(np.linspace(0, len(run.times) - 1, DOTS).astype(int))
    angle, time = run.observables["theta"][kept] / TURN, run.times[kept] / motion.period
    rate = run.observables["theta_dot"][kept]
    momentum = motion.inertia * rate
    return {
        "b": (angle, time),
        "c": (angle, momentum),
        "d": (time, momentum),
        "e": (time, rate),
    }


GALLERIES = Analysis(TEMPLATE, numbers, requests)
SOLVED = (TEMPLATE, solved)
