"""The bob's path x(t), y(t): the linear pendulum beside the non-linear one."""

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
    LINEAR_SCENES,
    NONLINEAR_SCENES,
    NOTEBOOK_DURATION,
    NOTEBOOK_TIMES,
    fine_motion,
)

BOB_CASE, BOB_FIGURE_TIME = "free-large", 6.0  # case 2; [s] duration of the figure
VISIBLE_DISTANCE = 0.1  # visible distance of the two bobs, relative to the length of 1 m
ACCELEROMETER = ExtraRun(
    NONLINEAR_SCENES + BOB_CASE, "mujoco/rk4", 1e-3, 3.0, (), (("reads_acceleration", True),)
)
BOB_FIGURE_TIMES = np.linspace(0.0, BOB_FIGURE_TIME, 240)  # [s]


def bob_path(scene: str, motion: Signals) -> Array:
    """Returns x and y of the bob [m], shape (n, 2), for a motion of a scene at n times."""
    return bob_place(case(scene).problem.length, motion["theta"])


def bob_distances(name: str) -> Array:
    """Returns the distance [m] between the two bobs of a case at the times NOTEBOOK_TIMES, shape
    (n,)."""
    simple = bob_path(NONLINEAR_SCENES + name, fine_motion(NONLINEAR_SCENES + name))
    linear = bob_path(LINEAR_SCENES + name, fine_motion(LINEAR_SCENES + name))
    return np.asarray(np.hypot(*(simple - linear).T))


def accelerometer(study: Study) -> Record:
    """Returns the readings of MuJoCo's accelerometer at the bob in case 2."""
    run = study.answer(ACCELEROMETER)
    return Record(accelerometer=None if run is None else accelerometer_readings(run))


def numbers() -> Record:
    """Returns the distances between the two bobs in each case, and the paths of both in case 2."""
    scenes = (NONLINEAR_SCENES + BOB_CASE, LINEAR_SCENES + BOB_CASE)
    return Record(
        distances=[_distance(label, name) for label, name in CASES.items()],
        times=BOB_FIGURE_TIMES,
        # [m] x and y of each bob at these times, shape (2, n)
        paths=[
            bob_path(scene, case(scene).reference.observe(BOB_FIGURE_TIMES)).T
            for scene in scenes
        ],
        apart=VISIBLE_DISTANCE,  # [m]
        duration=NOTEBOOK_DURATION,
        shown=BOB_FIGURE_TIME,
    )


def accelerometer_readings(run: Trajectory) -> Record | None:
    """Returns the readings of an accelerometer at MuJoCo's bob in case 2, beside the exact
    acceleration [m/s^2]; None if the run has no readings."""
    if "acceleration_across" not in run.channels:
        return None
    pendulum = case(ACCELEROMETER.scene).problem.started
    state = case(ACCELEROMETER.scene).reference.observe(run.times)
    sine = np.sin(state["theta"])
    cosine = np.cos(state["theta"])
    across = -pendulum.gravity * sine  # L θ̈, by the equation of motion
    along = pendulum.length * state["theta_dot"] ** 2
    read_across = run.channels["acceleration_across"]
    read_along = run.channels["acceleration_along"]
    # An accelerometer reads the acceleration minus gravity.
    gap_across = np.abs(read_across - pendulum.gravity * sine - across).max()
    gap_along = np.abs(read_along - pendulum.gravity * cosine - along).max()
    pull = run.observables["tension"] / pendulum.mass
    return Record(
        across=np.abs(across).max(),  # largest |L θ̈|
        along=along.max(),  # largest L θ̇²
        # largest difference between a reading plus gravity and L θ̈ or L θ̇²
        gap=max(gap_across, gap_along),
        reads_across=np.abs(read_across).max(),  # largest reading across the rod
        # largest difference of the reading along the rod from T/m of the engine's force sensor
        gap_of_pull=np.abs(read_along - pull).max(),
    )


def _distance(label: str, name: str) -> Record:
    """Returns the largest distance between the two bobs of a case, and the time at which it first
    exceeds VISIBLE_DISTANCE."""
    separation = bob_distances(name)
    beyond = np.flatnonzero(
        separation > VISIBLE_DISTANCE * case(NONLINEAR_SCENES + name).problem.length
    )
    return Record(
        label=label,
        largest=separation.max(),  # [m]
        # [s] time of the distance VISIBLE_DISTANCE
        parted=NOTEBOOK_TIMES[beyond[0]] if beyond.size else None,
    )


BOB = Analysis(
    "simple_pendulum/notebook_bob",
    accelerometer,
    lambda plan: (ACCELEROMETER,),
    exact=numbers,
)
