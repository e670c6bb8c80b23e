"""Action and phase: I(H) and Omega(H) through the wells and across the separatrices, with periods
measured in engines; and the period of the simple pendulum against its amplitude."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.pendulums.action_curves import Branch, branches
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.claims import AGREES, at_most
from plumbob.reports.analyses.cone_pendulum.hamiltonian import MUJOCO, ROTATING
from plumbob.reports.analyses.energy_drift import in_double
from plumbob.reports.analyses.measurements import PERIODS, swing_period, turn_period
from plumbob.reports.view.content import Figure, Finding, Statement, Table, method_cell, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import BLUE, GREEN, GREY, ORANGE, PINK, RED
from plumbob.reports.view.sources import SUDAKOV
from plumbob.reports.view.traces import Trace, curve, figure, linear, logarithmic, marks, positive

STEP = 2e-4  # [s]
DEEP, SHALLOW = 1.5262823409896228, -1.4708157898939431  # [rad], the wells at 26 rad/s
STARTS = (
    *((DEEP, speed) for speed in (5.0, 20.0, 33.0, 34.5, 36.0, 36.5, 40.0, 48.0, 60.0)),
    *((SHALLOW, speed) for speed in (3.0, 10.0, 13.0)),
)  # theta [rad], theta_dot [rad/s]
HIGHEST = 1100.0  # [J]
SWING, SWING_STEP = "simple-pendulum/free-large", 1e-3
AMPLITUDES = (0.3, 1.0, 2.0, 2.8, 3.1)  # [rad]
SWING_METHODS = ("mujoco/rk4", "pymunk/tight")
COLOURS = (BLUE, GREEN, ORANGE, RED)


@dataclass(frozen=True)
class Measured:
    """A start of STARTS: energy [J], exact and measured period [s], largest change of the action
    over the run, relative."""

    energy: float
    exact: float
    seen: float | None
    drift: float | None


@cache
def started(theta: float, speed: float) -> ConePendulum:
    """The source's cone on its turning platform from another start."""
    scene = find_scene(ROTATING, {"theta": theta, "theta_dot": speed})
    return case_of(scene).problem  # type: ignore[no-any-return]


def _request(theta: float, speed: float) -> ExtraRun:
    duration = PERIODS * started(theta, speed).motion.period
    return ExtraRun(ROTATING, MUJOCO, STEP, duration, (("theta", theta), ("theta_dot", speed)))


def swing_time(amplitude: float) -> float:
    """Exact period [s] of the simple pendulum with an amplitude [rad]."""
    problem = case_of(find_scene(SWING, {"theta": -amplitude})).problem
    return float(problem.elliptic.period)


def _swing(method: str, amplitude: float) -> ExtraRun:
    duration = PERIODS * swing_time(amplitude)
    return ExtraRun(SWING, method, SWING_STEP, duration, (("theta", -amplitude),))


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Three periods of MuJoCo's full model from each start, and of two engines' simple pendulum."""
    return (
        *(_request(*start) for start in STARTS),
        *(_swing(method, size) for method in SWING_METHODS for size in AMPLITUDES),
    )


def measured(study: Study) -> tuple[Measured, ...]:
    """Energy and periods of each start."""
    rows = []
    for theta, speed in STARTS:
        problem, run = started(theta, speed), study.recording(_request(theta, speed))
        motion = problem.motion
        rotates = motion.regime == "rotation"
        period = turn_period(run) if rotates else swing_period(run, theta)
        drift = None
        if run is not None:
            system = case_of(find_scene(ROTATING)).system
            drift = float(np.abs(system.invariants(problem, run.observables)["action"]).max())
        rows.append(Measured(float(double(motion.energy)), motion.period, period, drift))
    return tuple(rows)


@cache
def curves() -> tuple[Branch, ...]:
    """The branches of the source's cone on its turning platform."""
    problem = started(DEEP, 40.0)
    return branches(in_double(problem.potential), problem.body.inertia_x, HIGHEST)


def finding(study: Study) -> Finding:
    """The action as the engines see it: constant, with the period as its derivative."""
    points = measured(study)
    gaps = [abs(p.seen / p.exact - 1.0) for p in points if p.seen is not None]
    drifts = [p.drift for p in points if p.drift is not None]
    deep, shallow, both, rotation = (branch.actions for branch in curves())
    table = Table(
        "Periods and actions measured in MuJoCo's full model",
        ("start θ, dθ/dt", "H [J]", "regime", "period, exact [s]", "period, measured [s]",
         "relative difference", "largest change of I, relative"),
        tuple(
            row(
                f"{number(theta)} rad, {number(speed)} rad/s",
                value(p.energy, 5),
                started(theta, speed).motion.regime,
                value(p.exact, 8),
                value(p.seen, 8),
                value(None if p.seen is None else p.seen / p.exact - 1.0, 2),
                value(p.drift, 2),
            )
            for (theta, speed), p in zip(STARTS, points, strict=True)
        ),
    )  # fmt: skip
    return Finding(
        "action-phase",
        "Action and phase (10)–(13) hold in every well and across the separatrices",
        "extended",
        "Periods and actions can be taken from the formulas for swinging motions too. "
        f"Periods measured in MuJoCo differ from 2π dI/dH by at most "
        f"{number(max(gaps, default=0.0), 2)}, relative; the action of its runs is constant to "
        f"{number(max(drifts, default=0.0), 2)}.",
        (
            "The source introduces action and phase for rotation only. They hold for swinging in "
            "either well and over both, too. Upward across the lower separatrix the actions of "
            f"the wells add up ({number(deep[-1], 4)} + {number(shallow[-1], 4)} J s to "
            f"{number(both[0], 4)} J s); across the upper one the action halves "
            f"({number(both[-1], 4)} to {number(rotation[0], 4)} J s), because a rotation passes "
            "each angle one way only. The frequency falls to zero at either.",
        ),
        (table, _swings_table(study)),
        (*_figures(points), _swings(study)),
        (
            f"plumbob solve {ROTATING} --set theta={SHALLOW} --set theta_dot=10",
            f"plumbob run {ROTATING} {MUJOCO} --step {STEP:g} --set theta={SHALLOW} "
            "--set theta_dot=10",
        ),
        (
            Statement(
                SUDAKOV,
                "(10)–(13)",
                "Action I and phase Φ = Ωt of a rotation, with Ω = dH/dI",
                "for rotation only",
                "in every well too: periods in MuJoCo within "
                f"{number(max(gaps, default=0.0), 2)}, relative; I constant to "
                f"{number(max(drifts, default=0.0), 2)}",
                "extended",
            ),
        ),
        claims=(
            at_most(
                "the largest difference of a period, relative,", max(gaps, default=np.nan), AGREES
            ),
            at_most(
                "the largest change of an action, relative,", max(drifts, default=np.nan), AGREES
            ),
        ),
    )


def _figures(points: Sequence[Measured]) -> list[Figure]:
    actions: list[Trace] = []
    rates: list[Trace] = []
    for branch, colour in zip(curves(), COLOURS, strict=False):
        actions.append(curve(branch.energies, branch.actions, colour=colour, name=branch.name))
        rates.append(curve(branch.energies, branch.rates, colour=colour, name=branch.name))
    timed = [p for p in points if p.seen]
    dots = [2 * math.pi / p.seen for p in timed if p.seen]
    rates.append(marks([p.energy for p in timed], dots, GREY, "MuJoCo"))
    energy = linear("H [J]")
    note = "Jumps at the separatrices: the wells' orbits join, then a turn is half of an orbit."
    return [
        figure("I(H), eq. 10", note, actions, energy, linear("action I [J s]"), legend=True),
        figure(
            "Ω(H), eq. 12",
            "The slope of H(I); grey: 2π over periods measured in MuJoCo's full model.",
            rates,
            energy,
            linear("Ω = dH/dI [rad/s]"),
            legend=True,
        ),
    ]


def _swings(study: Study) -> Figure:
    """The simple pendulum's period against amplitude, closed form and engines."""
    small = swing_time(1e-6)
    sizes = np.concatenate([np.linspace(0.02, 3.0, 60), math.pi - np.geomspace(0.14, 1e-4, 30)])
    periods = [swing_time(float(size)) / small for size in sizes]
    traces: list[Trace] = [curve(sizes, periods, colour=BLUE, name="closed form")]
    for method, colour in zip(SWING_METHODS, (RED, PINK), strict=True):
        dots = {s: swing_period(study.recording(_swing(method, s)), 0.0) for s in AMPLITUDES}
        kept = {size: period / small for size, period in dots.items() if period is not None}
        if kept:
            traces.append(marks(list(kept), positive(list(kept.values())), colour, method))
    return figure(
        "Simple pendulum: period against amplitude",
        "Over that of small swings; a = b = 0 in the same closed form.",
        traces,
        linear("amplitude [rad]"),
        logarithmic("T / 2π√(L/g)"),
        legend=True,
    )


def _swings_table(study: Study) -> Table:
    rows = []
    for method in SWING_METHODS:
        for size in AMPLITUDES:
            exact, dots = swing_time(size), swing_period(study.recording(_swing(method, size)), 0.0)
            gap = None if dots is None else dots / exact - 1.0
            cells = (value(size, 2), value(exact, 8), value(dots, 8), value(gap, 2))
            rows.append(row(method_cell(method), *cells))
    heads = ("method", "amplitude [rad]", "period, exact [s]", "period, measured [s]",
             "relative difference")  # fmt: skip
    return Table(
        f"Simple pendulum: periods measured at a step of {SWING_STEP:g} s",
        heads,
        tuple(rows),
        folded=True,
    )
