"""The printed Hamiltonian (9) of the source contradicts the Lagrangian (7) it is made from."""

from __future__ import annotations

from functools import cache
from types import MappingProxyType

import numpy as np

from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, clear
from plumbob.reports.analyses.measurements import case, energy

RESTING, ROTATING = "cone-pendulum/resting-base", "cone-pendulum/rotating-base"
MUJOCO, MUJOCO_STEP = "mujoco/rk4", 1e-4  # its full model: platform, hinge and cone
LAGRANGE, LAGRANGE_RTOL = "ode/dop853", 1e-13  # eq. 7's equation of motion, integrated
END = 0.5  # [s]
INDEPENDENT = MappingProxyType(
    {
        "mujoco": ExtraRun(ROTATING, MUJOCO, MUJOCO_STEP, END),
        "lagrange": ExtraRun(ROTATING, LAGRANGE, LAGRANGE_RTOL, END),
    }
)
TIMES = np.linspace(0.0, END, 501)  # [s], of which every other one is drawn


@cache
def cone(**changes: float) -> ConePendulum:
    """The source's cone on its turning platform, some of its parameters changed."""
    return case_of(find_scene(ROTATING, changes)).problem  # type: ignore[no-any-return]


@cache
def forms(name: str) -> Record:
    """Both closed forms of a scene, whose tables take a tenth of a second each."""
    problem: ConePendulum = case(name).problem
    return Record(
        problem=problem,
        correct=problem.motion,
        printed=problem.printed_motion(),  # of eqs. 9, 15 and 16
    )


def numbers(study: Study) -> Record:
    """Both closed forms beside the recorded runs of the independent methods."""
    both = forms(ROTATING)
    recorded = {name: study.answer(request) for name, request in INDEPENDENT.items()}
    runs = {name: _independent(both, run) for name, run in recorded.items() if run}
    correct = _closed_form(both.correct)
    printed = _closed_form(both.printed)
    between = both.printed.state(TIMES)[0] - both.correct.state(TIMES)[0]
    gap = abs(printed.end - correct.end)
    return Record(
        correct=correct,
        printed=printed,
        runs=runs,
        apart=np.abs(between).max(),  # largest distance of the closed forms [rad]
        times=TIMES[::2],  # [s], that are drawn
        theta=both.problem.theta,  # at the start [rad]
        theta_dot=both.problem.theta_dot,  # [rad/s]
        platform_rate=both.problem.platform_rate,  # [rad/s]
        time=END,
        scene=ROTATING,
        mujoco=MUJOCO,
        lagrange=LAGRANGE,
        gap=gap,  # distance of the closed forms at END [rad]
        # largest distance of a method from the correct form, smallest from the printed one [rad]
        worst=max((run.from_correct for run in runs.values()), default=0.0),
        off=min((run.from_printed for run in runs.values()), default=gap),
    )


def claims(numbers: Record) -> Claims:
    """The methods are much nearer to the correct form."""
    text = "distances of the methods from the printed form and from the correct one"
    return (clear(text, numbers.off, numbers.worst, "rad"),)


def end_of(motion: PendulumMotion) -> float:
    """theta [rad] of an exact motion at END."""
    return float(motion.state(np.array([END]))[0][0])


def _closed_form(motion: PendulumMotion) -> Record:
    """The end and the period [s] of a closed form, and theta at times drawn."""
    theta = motion.state(TIMES[::2])[0]
    return Record(end=end_of(motion), period=motion.period, theta=theta)


def _independent(both: Record, run: Trajectory) -> Record:
    """A recorded run of an independent method, beside both closed forms."""
    theta = run.observables["theta"]
    errors = theta - both.correct.state(run.times)[0]
    apart = theta - both.printed.state(run.times)[0]
    correct, printed = (
        float(np.ptp(energy(motion.potential, motion.inertia, run)))
        for motion in (both.correct, both.printed)
    )
    return Record(
        from_correct=np.abs(errors).max(),  # largest distance [rad]
        from_printed=np.abs(apart).max(),
        correct_varies=correct,  # of the correct Hamiltonian along the run [J]
        printed_varies=printed,
        times=run.times,  # [s]
        theta=theta,  # [rad]
    )


PRINTED = Analysis(
    "cone_pendulum/printed_hamiltonian",
    numbers,
    lambda plan: tuple(INDEPENDENT.values()),
    claims,
)
