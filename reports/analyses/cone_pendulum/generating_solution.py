"""The exact motion as a generating solution: a weakly damped axle, a drive that is not ideal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from plumbob.analytic.errors.contact_models.driven_platform import drive_error
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.slow_change import DampedRotation, action_and_phase
from plumbob.engines.study.extra_runs import Changes, ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.claims import at_most
from plumbob.reports.analyses.cone_pendulum.action_phase import started
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    LAGRANGE,
    MUJOCO,
    MUJOCO_STEP,
    ROTATING,
    forms,
)
from plumbob.reports.analyses.energy_drift import in_double
from plumbob.reports.view.content import (
    Cell,
    Figure,
    Finding,
    Statement,
    Table,
    method_cell,
    row,
    value,
)
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import BLUE, GREEN, ORANGE, RED
from plumbob.reports.view.sources import SUDAKOV
from plumbob.reports.view.traces import Trace, curve, figure, linear, marks, over_time

SPEED = 60.0  # [rad/s], from theta = 0: half of the action is left when it comes to the barrier
WITHIN = 1e-2  # of the action: what first-order averaging leaves
DECAY = 0.16  # xi times the duration: what the action falls by
STEP, TOLERANCE = 2e-4, 1e-11
TURNS = (("quick", 65.0), ("full", 1100.0))  # of the longest run of a profile
INERTIAS = (1e3, 1e4, 1e5)  # [kg m^2] of the platform
OWN = 1.0  # [kg m^2] of the platform in the model's file, beside it
DRIVE_RATE, DRIVE_TIME = 5.0, 2.0  # [1/s], [s]
PLACES = 12  # of a run that are looked at


Line = tuple[Cell, ...]


@dataclass(frozen=True)
class Damped:
    """A rotation with a damped axle: rate xi [1/s], and how long [s]."""

    xi: float
    duration: float

    def request(self, method: str) -> ExtraRun:
        """The run with a method."""
        step = TOLERANCE if method == LAGRANGE else STEP
        changes: Changes = (("theta_dot", SPEED),)
        settings: Changes = (("axle_damping_rate", self.xi),)
        return ExtraRun(ROTATING, method, step, self.duration, changes, settings)


def damped(profile: str) -> tuple[Damped, ...]:
    """The runs of a profile: each twice as long as the one before, and half as damped."""
    period = started(0.0, SPEED).motion.period
    longest = dict(TURNS)[profile] * period
    return tuple(Damped(DECAY / t, t) for t in (longest / 4, longest / 2, longest))


def _methods(profile: str) -> tuple[str, ...]:
    return (MUJOCO, LAGRANGE) if profile == "full" else (MUJOCO,)


def _drive(inertia: float) -> ExtraRun:
    settings: Changes = (("platform_armature", inertia), ("drive_rate", DRIVE_RATE))
    return ExtraRun(ROTATING, MUJOCO, MUJOCO_STEP, DRIVE_TIME, (), settings)


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Damped rotations, over a thousand turns in the full profile; platforms with weak drives."""
    return (
        *(damping.request(m) for damping in damped(plan.profile) for m in _methods(plan.profile)),
        *(_drive(inertia) for inertia in INERTIAS),
    )


@cache
def averaged(xi: float) -> DampedRotation:
    """The averaged motion of the source's cone with a damped axle."""
    problem = started(0.0, SPEED)
    return DampedRotation(in_double(problem.potential), problem.body.inertia_x, SPEED, xi)


def course(run: Trajectory, xi: float) -> tuple[Array, Array, Array]:
    """Times [s], and the action [J s] and phase [rad] of a run at PLACES of its samples."""
    rule = averaged(xi)
    kept = np.linspace(0, len(run.times) - 1, PLACES + 1).astype(int)[1:]
    data = run.observables
    pairs = [
        action_and_phase(
            rule.potential, rule.inertia, float(data["theta"][i]), float(data["theta_dot"][i])
        )
        for i in kept
    ]
    return run.times[kept], *np.array(pairs).T


def finding(study: Study) -> Finding:
    """Averaging against a thousand turns, and first-order perturbation against a weak drive."""
    rows, worst, late, turns = [], 0.0, [], 0.0
    for damping in damped(study.profile):
        rule = averaged(damping.xi)
        for method in _methods(study.profile):
            run = study.recording(damping.request(method))
            if run is None:
                continue
            times, actions, phases = course(run, damping.xi)
            off = float(np.abs(actions / rule.action(times) - 1.0).max())
            gap = float(phases[-1] - rule.phase(float(times[-1])))
            worst, turns = max(worst, off), max(turns, float(phases[-1]) / (2 * np.pi))
            late.append(abs(gap))
            rows.append(
                row(method_cell(method), value(damping.xi), value(phases[-1] / (2 * np.pi), 5),
                    value(off, 2), value(gap, 2))
            )  # fmt: skip
    drive_rows, drives = _drives(study)
    heads = ("method", "ξ [1/s]", "turns", "largest difference of I from I₀ e^(–ξt), relative",
             "difference of the phase at the end [rad]")  # fmt: skip
    return Finding(
        "generating-solution",
        "The exact motion generates perturbation solutions: damping and a drive that is not ideal",
        "confirmed",
        "With weak damping or an imperfect drive, averaging along the exact motion gives the "
        "slow change without a simulation. "
        f"With a damped axle the action falls as e^(–ξt), within {number(worst, 2)}, relative; "
        f"after {number(turns, 4)} turns the averaged phase differs by "
        f"{number(max(late, default=0.0), 2)} rad.",
        (
            "The source means its solution as a generating one for perturbation methods, in "
            "electric drives. With a torque –ξI dθ/dt on the axle dH/dt = –ξI(dθ/dt)², whose mean "
            "is –ξΩI by (10) and (12): dI/dt = –ξI for every potential. The phase is the integral "
            "of Ω, which is (1/ξ)∫dH/I. Each run is twice as long as the one before and half as "
            "damped: the phase's difference stays the same, as first-order averaging has it.",
            "A drive that is not ideal: the platform has a finite inertia A, and a torque "
            f"proportional to the lack of rate, {number(DRIVE_RATE)}/s times A, holds its mean. "
            "To first order in 1/A its rate changes by u/A and θ leaves the ideal motion by d/A, "
            "by two linear equations along the exact motion (THEORY.md).",
        ),
        (
            Table("A damped axle, averaged", heads, tuple(rows)),
            Table(
                f"A platform with a weak drive: θ after {DRIVE_TIME:g} s, less the ideal one",
                ("A [kg m²]", "MuJoCo [rad]", "first order [rad]", "relative difference"),
                drive_rows,
            ),
        ),
        (*_decays(study), *_drive_figure(drives)),
        (f"plumbob validate --profile full --scenes {ROTATING} --methods {MUJOCO},{LAGRANGE}",),
        (
            Statement(
                SUDAKOV,
                "introduction",
                "The solution can generate others, by perturbation, in electric drives",
                "can",
                f"a damped axle over {number(turns, 4)} turns: dI/dt = –ξI within "
                f"{number(worst, 2)}; a weak drive: first order within "
                f"{', '.join(line[-1].text for line in drive_rows)} at A = "
                f"{', '.join(line[0].text for line in drive_rows)} kg m²",
                "holds",
            ),
        ),
        claims=(
            at_most(
                "the largest difference of an action from the averaged one, relative,",
                worst,
                WITHIN,
            ),
        ),
    )


def _drives(
    study: Study,
) -> tuple[tuple[Line, ...], Mapping[float, tuple[Array, ...]]]:
    problem, rows, drives = forms(ROTATING).problem, [], {}
    for inertia in INERTIAS:
        run = study.recording(_drive(inertia))
        if run is None:
            continue
        # the servo's gain is DRIVE_RATE times the armature, and moves the platform's own too
        rate = DRIVE_RATE * inertia / (inertia + OWN)
        first = drive_error(problem, run.times, inertia + OWN, rate).theta
        apart = run.observables["theta"] - problem.reference.state(run.times)[0]
        gap = float(apart[-1] / first[-1] - 1.0)
        rows.append(row(value(inertia, 2), value(apart[-1], 4), value(first[-1], 4), value(gap, 2)))
        drives[inertia] = (run.times, apart * inertia, first * inertia)
    return tuple(rows), drives


def _decays(study: Study) -> list[Figure]:
    longest = damped(study.profile)[-1]
    rule = averaged(longest.xi)
    times = np.linspace(0.0, longest.duration, 61)
    traces: list[Trace] = [curve(times, rule.action(times), colour=BLUE, name="I₀ e^(–ξt)")]
    run = study.recording(longest.request(MUJOCO))
    if run is not None:
        at, actions, _ = course(run, longest.xi)
        traces.append(marks(at, actions, RED, "MuJoCo"))
    caption = f"ξ = {number(longest.xi)}/s, from {number(SPEED)} rad/s on the turning platform."
    return [over_time("Action of a damped rotation", caption, traces, linear("action I [J s]"))]


def _drive_figure(drives: Mapping[float, tuple[Array, ...]]) -> list[Figure]:
    if not drives:
        return []
    times, _, first = next(iter(drives.values()))
    traces: list[Trace] = [curve(times, first, colour=BLUE, name="first order")]
    for (inertia, (at, apart, _)), colour in zip(drives.items(), (RED, ORANGE, GREEN), strict=True):
        traces.append(marks(at[::8], apart[::8], colour, f"MuJoCo, A {number(inertia)}", size=4))
    return [
        figure(
            "A drive that is not ideal: deviation of θ, times A",
            "One curve to first order, whatever A; the lightest platform leaves it first.",
            traces,
            linear("time [s]"),
            linear("A (θ – ideal θ) [kg m² rad]"),
            legend=True,
        )
    ]
