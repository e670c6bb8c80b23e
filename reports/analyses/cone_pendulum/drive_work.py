"""The energies of Fig. 3: T + U changes by the work of the drive, in MuJoCo's own energy too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.platform_energy import Energies, drive_torque, energies
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.request import Changes
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.claims import Claims, clear
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    END,
    MUJOCO,
    MUJOCO_STEP,
    ROTATING,
    forms,
)
from plumbob.reports.analyses.measurements import extremes, largest

# So light that its own energy leaves the body's with eight digits, so heavy that its rate changes
# by 2.4e-7 rad/s only.
ARMATURE = 1e8  # [kg m^2]
OWN_INERTIA = 1.0  # [kg m^2] of the platform in the model's file, beside the armature
SETTINGS: Changes = (("platform_armature", ARMATURE), ("reads_energy", True))
RUN = ExtraRun(ROTATING, MUJOCO, MUJOCO_STEP, END, (), SETTINGS)
PARTS = ("translation", "coupling", "rotation")


@dataclass(frozen=True)
class Platform:
    """MuJoCo's own energies [J] over a run whose platform has a finite inertia."""

    total: Array  # T + U of the body
    range: float  # of that
    gap: float  # largest difference of that from the exact one
    supplied_range: float  # of what the platform has given away
    supplied_gap: float  # largest difference of that from the exact work of the drive


@dataclass(frozen=True)
class DriveWork:
    """Energies [J] over the motion of Fig. 3, and the torque [N m] of the drive."""

    times: Array  # [s]
    exact: Energies
    swing: float  # range of T + U
    constant: float  # range of T + U less the work of the drive
    extremes: Mapping[str, tuple[float, float]]  # of the parts of T
    others: float  # largest of the parts of T but ½ I_x θ̇², with a platform at rest
    torque: float  # largest
    mujoco: Platform | None
    inertia: float = ARMATURE
    end: float = END


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """MuJoCo's full model with a platform whose energy can be read."""
    return (RUN,)


def along(times: Array) -> Energies:
    """The exact energies at `times` [s], shape (n,)."""
    problem = forms(ROTATING).problem
    return energies(problem, *problem.reference.state(times))


def numbers(study: Study) -> DriveWork:
    """T + U is not constant; T + U less the work of the drive is."""
    run = study.answer(RUN)
    times = np.linspace(0.0, END, 251) if run is None else run.times
    exact, problem = along(times), forms(ROTATING).problem
    states = problem.reference.state
    still = energies(replace(problem, platform_rate=0.0), *states(times))
    return DriveWork(
        times,
        exact,
        float(np.ptp(_span("total", times))),
        float(np.ptp(exact.total - exact.work)),
        {part: _span(part, times) for part in PARTS},
        float(np.abs(still.kinetic - still.rotation).max()),
        largest(lambda t: drive_torque(problem, *states(t)), times),
        None if run is None else _platform(run, exact),
    )


def _span(part: str, times: Array) -> tuple[float, float]:
    """The lowest and the highest value of an exact energy [J]."""
    return extremes(lambda t: getattr(along(t), part), times)


def _platform(run: Trajectory, exact: Energies) -> Platform | None:
    """MuJoCo's own energies; None where the run has none."""
    if not {"kinetic", "potential", "platform_rate"} <= set(run.channels):
        return None
    rate, inertia = run.channels["platform_rate"], ARMATURE + OWN_INERTIA
    body = run.channels["kinetic"] + run.channels["potential"] - inertia * rate**2 / 2
    # the difference of squares, without the digits that they have in common
    supplied = inertia * (rate[0] - rate) * (rate[0] + rate) / 2
    gaps = (float(np.abs(gap).max()) for gap in (body - exact.total, supplied - exact.work))
    body_gap, supplied_gap = gaps
    return Platform(body, float(np.ptp(body)), body_gap, float(np.ptp(supplied)), supplied_gap)


def claims(work: DriveWork) -> Claims:
    """T + U changes in MuJoCo as it does exactly."""
    if work.mujoco is None:
        return ()
    what = "the change of T + U, and the distance of MuJoCo's own energy"
    return (clear(what, work.swing, work.mujoco.gap, "J"),)


DRIVE_WORK = Analysis("cone_pendulum/drive_work", numbers, requests, claims)
