"""The bob in the plane, x(t) and y(t): the linear pendulum beside the non-linear one."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.pendulums.rod_tension import bob_place
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import case
from plumbob.reports.analyses.simple_pendulum.notebook import (
    CASES,
    DURATION,
    FINE,
    LINEAR,
    SIMPLE,
    fine,
)

DRAWN, SHOWN = "free-large", 6.0  # case 2, and its first seconds
APART = 0.1  # of the length, 1 m: what a picture of the two shows
ACCELEROMETER = ExtraRun(
    SIMPLE + DRAWN, "mujoco/rk4", 1e-3, 3.0, (), (("reads_acceleration", True),)
)
SHORT = np.linspace(0.0, SHOWN, 240)  # [s]


def place(scene: str, motion: Signals) -> Array:
    """x and y of the bob [m], shape (n, 2), of the exact motion of a scene at n times."""
    return bob_place(case(scene).problem.length, motion["theta"])


def distances(name: str) -> Array:
    """Distance [m] of the two bobs of a case at FINE, shape (n,)."""
    apart = np.subtract(*(place(kind + name, fine(kind + name)) for kind in (SIMPLE, LINEAR)))
    return np.asarray(np.hypot(*apart.T))


def numbers(study: Study) -> Record:
    """How far the two bobs are apart in each case, and both in the plane."""
    return Record(
        distances=[_distance(label, name) for label, name in CASES.items()],
        times=SHORT,
        # x and y of both bobs [m] at them, shape (2, n)
        paths=[
            place(kind + DRAWN, case(kind + DRAWN).reference.observe(SHORT)).T
            for kind in (SIMPLE, LINEAR)
        ],
        accelerometer=None if (run := study.answer(ACCELEROMETER)) is None else readings(run),
        apart=APART,  # [m]
        duration=DURATION,
        shown=SHOWN,
    )


def readings(run: Trajectory) -> Record | None:
    """Readings at MuJoCo's bob in case 2, against the exact acceleration [m/s^2]."""
    if "acceleration_across" not in run.channels:
        return None
    pendulum = case(ACCELEROMETER.scene).problem.started
    state = case(ACCELEROMETER.scene).reference.observe(run.times)
    sine = np.sin(state["theta"])
    cosine = np.cos(state["theta"])
    across = -pendulum.gravity * sine  # L θ̈, by the equation of motion
    along = pendulum.length * state["theta_dot"] ** 2
    reads = run.channels["acceleration_across"], run.channels["acceleration_along"]
    free_fall = -pendulum.gravity * sine, -pendulum.gravity * cosine
    moved = [read + fall for read, fall in zip(reads, free_fall, strict=True)]
    return Record(
        across=np.abs(across).max(),  # largest |L θ̈|
        along=along.max(),  # largest L θ̇²
        # largest difference of the readings, gravity added, from those two
        gap=max(np.abs(moved[0] - across).max(), np.abs(moved[1] - along).max()),
        reads_across=np.abs(reads[0]).max(),  # largest reading across the rod, as it is
        # largest difference of that along it from T/m of the engine's own sensor
        gap_of_pull=np.abs(reads[1] - run.observables["tension"] / pendulum.mass).max(),
    )


def _distance(label: str, name: str) -> Record:
    """How far the two bobs of a case are apart."""
    apart = distances(name)
    over = np.flatnonzero(apart > APART * case(SIMPLE + name).problem.length)
    return Record(
        label=label,
        largest=apart.max(),  # [m]
        parted=FINE[over[0]] if over.size else None,  # [s], when they first are by APART
    )


BOB = Analysis("simple_pendulum/notebook_bob", numbers, lambda plan: (ACCELEROMETER,))
