"""The source's printed Hamiltonian (9), which contradicts the Lagrangian (7) it is derived from."""

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
from plumbob.reports.analyses.claims import Claims, clearly_larger
from plumbob.reports.analyses.measurements import case, pendulum_energy

RESTING, ROTATING = "cone-pendulum/resting-base", "cone-pendulum/rotating-base"
# full model (platform, hinge and cone) and its step [s]
FULL_MODEL_METHOD, FULL_MODEL_STEP = "mujoco/rk4", 1e-4
LAGRANGE, LAGRANGE_RTOL = "ode/dop853", 1e-13  # integrates the equation of motion of eq. 7
END = 0.5  # [s]
INDEPENDENT = MappingProxyType(
    {
        "mujoco": ExtraRun(ROTATING, FULL_MODEL_METHOD, FULL_MODEL_STEP, END),
        "lagrange": ExtraRun(ROTATING, LAGRANGE, LAGRANGE_RTOL, END),
    }
)
TIMES = np.linspace(0.0, END, 501)  # [s] compared times; every other one is drawn


@cache
def turning_cone(**changes: float) -> ConePendulum:
    """Returns the problem of the source's cone on its turning platform, with some parameters
    changed."""
    return case_of(find_scene(ROTATING, changes)).problem  # type: ignore[no-any-return]


@cache
def closed_forms(name: str) -> Record:
    """Returns the correct and the printed closed form of a scene. They are cached, because their
    tables take a tenth of a second each."""
    problem: ConePendulum = case(name).problem
    return Record(
        problem=problem,
        correct=problem.motion,
        printed=problem.printed_motion(),  # by eqs. 9, 15 and 16
    )


def numbers(study: Study) -> Record:
    """Returns both closed forms beside the recorded runs of independent methods."""
    both = closed_forms(ROTATING)
    recorded = {name: study.answer(request) for name, request in INDEPENDENT.items()}
    runs = {name: _compare(both, run) for name, run in recorded.items() if run}
    correct = _closed_form(both.correct)
    printed = _closed_form(both.printed)
    between = both.printed.state(TIMES)[0] - both.correct.state(TIMES)[0]
    gap = abs(printed.end - correct.end)
    return Record(
        correct=correct,
        printed=printed,
        runs=runs,
        apart=np.abs(between).max(),  # [rad] largest difference between the closed forms
        times=TIMES[::2],  # [s] times of the figure
        theta=both.problem.theta,  # [rad] at the start
        theta_dot=both.problem.theta_dot,  # [rad/s] at the start
        platform_rate=both.problem.platform_rate,  # [rad/s]
        time=END,
        scene=ROTATING,
        mujoco=FULL_MODEL_METHOD,
        lagrange=LAGRANGE,
        gap=gap,  # [rad] difference between the closed forms at END
        # [rad] largest difference of a method from the correct form; smallest from the printed form
        worst=max((run.from_correct for run in runs.values()), default=0.0),
        off=min((run.from_printed for run in runs.values()), default=gap),
    )


def claims(numbers: Record) -> Claims:
    """Returns the check that all methods are much nearer to the correct form."""
    text = "distances of the methods from the printed form and from the correct one"
    return (clearly_larger(text, numbers.off, numbers.worst, "rad"),)


def end_angle(motion: PendulumMotion) -> float:
    """Returns theta [rad] of an exact motion at END."""
    return float(motion.state(np.array([END]))[0][0])


def _closed_form(motion: PendulumMotion) -> Record:
    """Returns theta [rad] of a closed form at END and at the times of the figure, and its period
    [s]."""
    theta = motion.state(TIMES[::2])[0]
    return Record(end=end_angle(motion), period=motion.period, theta=theta)


def _compare(both: Record, run: Trajectory) -> Record:
    """Returns the comparison of a recorded run of an independent method with both closed forms."""
    theta = run.observables["theta"]
    from_correct = theta - both.correct.state(run.times)[0]
    from_printed = theta - both.printed.state(run.times)[0]
    correct_energy = pendulum_energy(both.correct.potential, both.correct.inertia, run)
    printed_energy = pendulum_energy(both.printed.potential, both.printed.inertia, run)
    return Record(
        from_correct=np.abs(from_correct).max(),  # [rad] largest difference
        from_printed=np.abs(from_printed).max(),  # [rad] largest difference
        # [J] range of each Hamiltonian along the run
        correct_varies=float(np.ptp(correct_energy)),
        printed_varies=float(np.ptp(printed_energy)),
        times=run.times,  # [s]
        theta=theta,  # [rad]
    )


PRINTED = Analysis(
    "cone_pendulum/printed_hamiltonian",
    numbers,
    lambda plan: tuple(INDEPENDENT.values()),
    claims,
)
