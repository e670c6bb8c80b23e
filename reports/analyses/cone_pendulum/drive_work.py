"""The energies of Fig. 3: T + U changes by the work of the drive, in MuJoCo's own energy too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.platform_energy import Energies, drive_torque, energies
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.request import Changes
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, clear
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    END,
    MUJOCO,
    MUJOCO_STEP,
    ROTATING,
    forms,
)

# So light that its own energy leaves the body's with eight digits, so heavy that its rate changes
# by 2.4e-7 rad/s only.
ARMATURE = 1e8  # [kg m^2]
OWN_INERTIA = 1.0  # [kg m^2] of the platform in the model's file, beside the armature
SETTINGS: Changes = (("platform_armature", ARMATURE), ("reads_energy", True))
RUN = ExtraRun(ROTATING, MUJOCO, MUJOCO_STEP, END, (), SETTINGS)
FINE = np.linspace(0.0, END, 20_001)  # [s]
PARTS = ("translation", "coupling", "rotation")


def along(times: Array) -> Energies:
    """The exact energies at `times` [s], shape (n,)."""
    problem = forms(ROTATING).problem
    return energies(problem, *problem.reference.state(times))


def numbers(study: Study) -> Record:
    """T + U is not constant; T + U less the work of the drive is."""
    run = study.answer(RUN)
    times = np.linspace(0.0, END, 251) if run is None else run.times
    exact = along(times)
    fine = along(FINE)
    problem = forms(ROTATING).problem
    states = problem.reference.state
    still = energies(replace(problem, platform_rate=0.0), *states(times))
    return Record(
        times=times,  # [s]
        exact=exact,
        swing=np.ptp(fine.total),  # range of T + U
        # range of T + U less the work of the drive
        constant=np.ptp(exact.total - exact.work),
        # the lowest and the highest of the parts of T
        extremes={part: (of.min(), of.max()) for part in PARTS for of in [getattr(fine, part)]},
        # largest of the parts of T but ½ I_x θ̇², with a platform at rest
        others=np.abs(still.kinetic - still.rotation).max(),
        torque=np.abs(drive_torque(problem, *states(FINE))).max(),  # largest
        mujoco=None if run is None else _platform(run, exact),
        inertia=ARMATURE,
        end=END,
    )


def _platform(run: Trajectory, exact: Energies) -> Record | None:
    """MuJoCo's own energies; None where the run has none."""
    if not {"kinetic", "potential", "platform_rate"} <= set(run.channels):
        return None
    rate = run.channels["platform_rate"]
    inertia = ARMATURE + OWN_INERTIA
    body = run.channels["kinetic"] + run.channels["potential"] - inertia * rate**2 / 2
    # the difference of squares, without the digits that they have in common
    supplied = inertia * (rate[0] - rate) * (rate[0] + rate) / 2
    gaps = (float(np.abs(gap).max()) for gap in (body - exact.total, supplied - exact.work))
    body_gap, supplied_gap = gaps
    return Record(
        total=body,  # T + U of the body
        range=np.ptp(body),  # of that
        gap=body_gap,  # largest difference of that from the exact one
        supplied_range=np.ptp(supplied),  # of what the platform has given away
        supplied_gap=supplied_gap,  # largest difference of that from the exact work of the drive
    )


def claims(work: Record) -> Claims:
    """T + U changes in MuJoCo as it does exactly."""
    if work.mujoco is None:
        return ()
    what = "the change of T + U, and the distance of MuJoCo's own energy"
    return (clear(what, work.swing, work.mujoco.gap, "J"),)


DRIVE_WORK = Analysis("cone_pendulum/drive_work", numbers, lambda plan: (RUN,), claims)
