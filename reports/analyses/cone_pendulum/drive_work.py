"""The finding on energies: T + U changes by the work of the drive, in MuJoCo's own energy too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.platform_energy import Energies, drive_torque, energies
from plumbob.engines.study.extra_runs import Changes, ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.claims import clear
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    END,
    MUJOCO,
    MUJOCO_STEP,
    ROTATING,
    forms,
)
from plumbob.reports.analyses.measurements import extremes, largest
from plumbob.reports.view.content import Figure, Finding, Statement, Table, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import BLUE, GREEN, GREY, ORANGE, PINK, RED
from plumbob.reports.view.sources import SUDAKOV
from plumbob.reports.view.traces import Trace, curve, linear, marks, over_time

# So light that its own energy leaves the body's with eight digits, so heavy that its rate changes
# by 2.4e-7 rad/s only.
ARMATURE = 1e8  # [kg m^2]
OWN_INERTIA = 1.0  # [kg m^2] of the platform in the model's file, beside the armature
SETTINGS: Changes = (("platform_armature", ARMATURE), ("reads_energy", True))
RUN = ExtraRun(ROTATING, MUJOCO, MUJOCO_STEP, END, (), SETTINGS)


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """MuJoCo's full model with a platform whose energy can be read."""
    return (RUN,)


def along(times: Array) -> Energies:
    """The exact energies at `times` [s], shape (n,)."""
    problem = forms(ROTATING).problem
    return energies(problem, *problem.reference.state(times))


def own_energy(run: Trajectory) -> tuple[Array, Array] | None:
    """MuJoCo's own T + U of the body [J], and the energy that the platform has released [J], shape
    (n,); None where the run has no energies."""
    if not {"kinetic", "potential", "platform_rate"} <= set(run.channels):
        return None
    rate = run.channels["platform_rate"]
    platform = (ARMATURE + OWN_INERTIA) * rate**2 / 2
    body = run.channels["kinetic"] + run.channels["potential"] - platform
    # the difference of squares, without the digits that they have in common
    supplied = (ARMATURE + OWN_INERTIA) * (rate[0] - rate) * (rate[0] + rate) / 2
    return body, supplied


def finding(study: Study) -> Finding:
    """T + U is not constant; T + U less the work of the drive is."""
    run = study.recording(RUN)
    in_mujoco = None if run is None else own_energy(run)
    times = np.linspace(0.0, END, 251) if run is None else run.times
    exact = along(times)
    problem = forms(ROTATING).problem
    swing = float(np.ptp(extremes(lambda t: along(t).total, times)))
    torque = largest(lambda t: drive_torque(problem, *problem.reference.state(t)), times)
    still = energies(replace(problem, platform_rate=0.0), *problem.reference.state(times))
    others = float(np.abs(still.kinetic - still.rotation).max())
    rows = [
        row("T + U, exact", value(swing), ""),
        row("T + U less the work of the drive, exact",
            value(float(np.ptp(exact.total - exact.work))), ""),
    ]  # fmt: skip
    text, gap = "", 0.0
    if in_mujoco is not None:
        body, supplied = in_mujoco
        gap = float(np.abs(body - exact.total).max())
        rows += [
            row("T + U, MuJoCo's own", value(float(np.ptp(body))), value(gap)),
            row("what MuJoCo's platform gives away", value(float(np.ptp(supplied))),
                value(float(np.abs(supplied - exact.work).max()))),
        ]  # fmt: skip
        text = f" MuJoCo's own energy agrees to {number(gap)} J."
    return Finding(
        "drive-work",
        "T + U changes by the work of the drive that keeps the platform's rate",
        "contradicted",
        "The drive of the platform does work, so constant energy T + U is no test of a "
        "simulation here. "
        f"Within {END} s T + U, which (9) takes for constant, changes by {number(swing)} J; all of "
        f"it is the work of the drive.{text}",
        (
            "The drive keeps ω against the body's changing angular momentum L about the vertical, "
            "and does the work ω(L – L₀). What is constant is T + U – ωL: the Jacobi integral, "
            "which the corrected (9) is. In MuJoCo the drive is a platform of large but finite "
            f"inertia ({number(ARMATURE)} kg m²): what it gives away is the same work.",
        ),
        (
            Table(
                "Energies along the motion of Fig. 3",
                ("energy", "range over the run [J]", "largest difference from the exact one [J]"),
                tuple(rows),
            ),
        ),
        (_figure(times, exact, in_mujoco),),
        (f"plumbob solve {ROTATING} --times 0.1,0.2,0.3,0.4,0.5",),
        (
            Statement(
                SUDAKOV,
                "(2)–(6), (9)",
                "T + U is constant",
                "575.246 J",
                f"changes by {number(swing)} J within {END} s: the work of the drive.{text}",
                "refuted",
            ),
            Statement(
                SUDAKOV,
                "(2)–(6)",
                "T is the sum of three parts: of translation, of inertia forces and of rotation",
                "(3), (4), (5)",
                f"as printed: {_range('translation', times)}, {_range('coupling', times)} and "
                f"{_range('rotation', times)} J on the motion of Fig. 3.{text}",
                "holds",
            ),
            Statement(
                SUDAKOV,
                "(6)",
                "Only ½ I_x θ̇² belongs to the swing; all other parts depend on the platform's rate",
                "½ I_x θ̇²",
                f"at ω = 0 the other parts are {number(others)} J",
                "holds" if others == 0.0 else "refuted",
            ),
            Statement(
                SUDAKOV,
                "characteristics",
                "The only external force that acts is applied at the centre of mass: gravity",
                "Mg",
                "the only applied force; the constraint that keeps ω has a reaction, a torque of "
                f"up to {number(torque, 6)} N m that does the work above",
                "extended",
            ),
        ),
        claims=(
            (
                clear(
                    "the change of T + U, and the distance of MuJoCo's own energy", swing, gap, "J"
                ),
            )
            if in_mujoco is not None
            else ()
        ),
    )


def _range(part: str, times: Array) -> str:
    low, high = map(number, extremes(lambda t: getattr(along(t), part), times))
    return low if low == high else f"{low} to {high}"


def _figure(times: Array, exact: Energies, energies: tuple[Array, Array] | None) -> Figure:
    traces: list[Trace] = [
        curve(times, values, colour=colour, name=name)
        for values, colour, name in (
            (exact.translation, GREY, "T of translation (3)"),
            (exact.coupling, ORANGE, "T of coupling (4)"),
            (exact.rotation, GREEN, "T of rotation (5)"),
            (exact.gravity, PINK, "U"),
            (exact.total, RED, "T + U"),
            (exact.work, BLUE, "work of the drive"),
        )
    ]
    if energies is not None:
        traces.append(marks(times[::12], energies[0][::12], RED, "T + U, MuJoCo", size=4))
    caption = "The parts of (6), their sum with U, and the work of the drive since the start."
    return over_time("Energies (2)–(6)", caption, traces, linear("energy [J]"), wide=True)
