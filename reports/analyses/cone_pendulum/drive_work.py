"""The energies of Fig. 3: T + U changes by the work of the drive, also in MuJoCo's energies."""

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
from plumbob.reports.analyses.claims import Claims, clearly_larger
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    END,
    FULL_MODEL_METHOD,
    FULL_MODEL_STEP,
    ROTATING,
    closed_forms,
)

# The platform is so light that the body's energy keeps eight digits beside the platform's, and so
# heavy that the platform's rate changes by only 2.4e-7 rad/s.
ARMATURE = 1e8  # [kg m^2] armature of the platform's joint
OWN_INERTIA = 1.0  # [kg m^2] inertia of the platform in the model file
WORK_SETTINGS: Changes = (("platform_armature", ARMATURE), ("reads_energy", True))
RUN = ExtraRun(ROTATING, FULL_MODEL_METHOD, FULL_MODEL_STEP, END, (), WORK_SETTINGS)
WORK_TIMES = np.linspace(0.0, END, 20_001)  # [s]
ENERGY_PARTS = ("translation", "coupling", "rotation")


def exact_energies(times: Array) -> Energies:
    """Returns the exact energies at `times` [s], shape (n,)."""
    problem = closed_forms(ROTATING).problem
    return energies(problem, *problem.reference.state(times))


def numbers(study: Study) -> Record:
    """Returns the energies over time, and the ranges of T + U, which is not constant, and of T + U
    minus the work of the drive, which is constant."""
    run = study.answer(RUN)
    times = np.linspace(0.0, END, 251) if run is None else run.times
    exact = exact_energies(times)
    fine = exact_energies(WORK_TIMES)
    parts = {name: getattr(fine, name) for name in ENERGY_PARTS}
    problem = closed_forms(ROTATING).problem
    states = problem.reference.state
    still = energies(replace(problem, platform_rate=0.0), *states(times))
    return Record(
        times=times,  # [s]
        exact=exact,
        swing=np.ptp(fine.total),  # range of T + U
        # range of T + U minus the work of the drive
        constant=np.ptp(exact.total - exact.work),
        # smallest and largest value of each part of T
        extremes={name: (values.min(), values.max()) for name, values in parts.items()},
        # largest sum of the parts of T other than ½ I_x θ̇², with a platform at rest
        others=np.abs(still.kinetic - still.rotation).max(),
        torque=np.abs(drive_torque(problem, *states(WORK_TIMES))).max(),  # largest magnitude
        mujoco=None if run is None else _mujoco_energies(run, exact),
        inertia=ARMATURE,
        end=END,
    )


def _mujoco_energies(run: Trajectory, exact: Energies) -> Record | None:
    """Returns MuJoCo's energies of the body and of the platform, compared with the exact ones; None
    if the run records no energies."""
    if not {"kinetic", "potential", "platform_rate"} <= set(run.channels):
        return None
    rate = run.channels["platform_rate"]
    inertia = ARMATURE + OWN_INERTIA
    body = run.channels["kinetic"] + run.channels["potential"] - inertia * rate**2 / 2
    # The product avoids the cancellation in the difference of the squared rates.
    supplied = inertia * (rate[0] - rate) * (rate[0] + rate) / 2
    body_gap = float(np.abs(body - exact.total).max())
    supplied_gap = float(np.abs(supplied - exact.work).max())
    return Record(
        total=body,  # T + U of the body
        range=np.ptp(body),  # range of T + U of the body
        gap=body_gap,  # largest difference of T + U from the exact one
        supplied_range=np.ptp(supplied),  # range of the energy that the platform has lost
        supplied_gap=supplied_gap,  # largest difference of that energy from the drive's exact work
    )


def claims(work: Record) -> Claims:
    """Returns the check that T + U changes in MuJoCo as in the exact motion."""
    if work.mujoco is None:
        return ()
    what = "the change of T + U, and the distance of MuJoCo's own energy"
    return (clearly_larger(what, work.swing, work.mujoco.gap, "J"),)


DRIVE_WORK = Analysis("cone_pendulum/drive_work", numbers, lambda plan: (RUN,), claims)
