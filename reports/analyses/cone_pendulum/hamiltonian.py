"""The finding that the printed Hamiltonian (9) contradicts the Lagrangian (7) it is made from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

import numpy as np

from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.claims import clear
from plumbob.reports.analyses.energy_drift import energy
from plumbob.reports.analyses.measurements import case
from plumbob.reports.view.content import Cell, Figure, Finding, Statement, Table, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import BLUE, GREY, PINK, RED
from plumbob.reports.view.sources import SUDAKOV
from plumbob.reports.view.traces import (
    Trace,
    curve,
    linear,
    logarithmic,
    marks,
    over_time,
    positive,
)

RESTING, ROTATING = "cone-pendulum/resting-base", "cone-pendulum/rotating-base"
MUJOCO, MUJOCO_STEP = "mujoco/rk4", 1e-4  # its full model: platform, hinge and cone
LAGRANGE, LAGRANGE_RTOL = "ode/dop853", 1e-13  # eq. 7's equation of motion, integrated
END = 0.5  # [s]
INDEPENDENT = MappingProxyType({
    "MuJoCo's full model": ExtraRun(ROTATING, MUJOCO, MUJOCO_STEP, END),
    "the equation of (7), integrated": ExtraRun(ROTATING, LAGRANGE, LAGRANGE_RTOL, END),
})  # fmt: skip
Runs = Mapping[str, Trajectory]


@dataclass(frozen=True)
class Forms:
    """A scene's problem with the corrected and the printed closed form of its motion."""

    problem: ConePendulum
    correct: PendulumMotion
    printed: PendulumMotion  # of eqs. 9, 15 and 16


@cache
def forms(name: str) -> Forms:
    """Both closed forms of a scene, whose tables take a tenth of a second each."""
    problem: ConePendulum = case(name).problem
    return Forms(problem, problem.motion, problem.printed_motion())


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The runs of two independent methods."""
    return tuple(INDEPENDENT.values())


def finding(study: Study) -> Finding:
    """Three curves, three independent methods, and the variation of each Hamiltonian along their
    runs."""
    both = forms(ROTATING)
    recorded = {name: study.recording(request) for name, request in INDEPENDENT.items()}
    runs = {name: run for name, run in recorded.items() if run is not None}
    gap = abs(_end(both.printed) - _end(both.correct))
    worst = max((_distance(both.correct, run) for run in runs.values()), default=0.0)
    off = min((_distance(both.printed, run) for run in runs.values()), default=gap)
    paragraphs = (
        "With the platform's rate prescribed, the conserved quantity is the Legendre transform of "
        "the Lagrangian, p dθ/dt – L = p²/2I + V with V = –a sin²θ – b sin θ – c cos θ (the Jacobi "
        "integral). The source prints a sin²θ + b sin θ – c cos θ: the centrifugal terms with the "
        "opposite sign. Eqs. 15 and 16 and the whole of Fig. 3 inherit the error. On a platform at "
        "rest a = b = 0 and the two agree, so Fig. 2 is right.",
        "Three independent methods without common code: MuJoCo steps a multibody model of the "
        "platform, hinge and cone, and uses no Hamiltonian; DOP853 integrates Lagrange's equation "
        "from (7); the closed form inverts the elliptic integral of the corrected Hamiltonian.",
    )
    return Finding(
        "printed-hamiltonian",
        "The printed Hamiltonian (9) contradicts the source's own Lagrangian (7)",
        "contradicted",
        "Do not use the paper's eq. 9 for a turning platform: it predicts another motion. "
        f"Eq. 9 is T + U, which is not conserved when the platform's rotation is prescribed. After "
        f"{END} s its motion is {number(gap)} rad away from that of eq. 7, which MuJoCo and an "
        f"integrated Lagrange equation follow to {number(worst)} rad.",
        paragraphs,
        (_agreement(both, runs), _mutual(both, runs), _conserved(both, runs)),
        (*_courses(both, runs), _distances(both, runs)),
        (
            f"plumbob run {ROTATING} {MUJOCO} --step 1e-4",
            f"plumbob run {ROTATING} {LAGRANGE} --step 1e-13",
            f"plumbob solve {ROTATING} --times {END}",
        ),
        (
            Statement(
                SUDAKOV,
                "(9), (15), (16), Fig. 3",
                "T + U is conserved; the motion of Fig. 3",
                f"V = a sin²θ + b sin θ – c cos θ: θ({END} s) = {_end(both.printed):.6f} rad, "
                f"period {both.printed.period:.6f} s",
                f"V = –a sin²θ – b sin θ – c cos θ: {_end(both.correct):.6f} rad, "
                f"{both.correct.period:.6f} s; independent methods within {number(worst)} rad",
                "refuted" if worst < off else "holds",
            ),
        ),
        claims=(
            clear(
                "distances of the methods from the printed form and from the correct one",
                off,
                worst,
                "rad",
            ),
        ),
    )


def _end(motion: PendulumMotion) -> float:
    return float(motion.state(np.array([END]))[0][0])


def _last(run: Trajectory) -> float:
    return float(run.observables["theta"][-1])


def _distance(motion: PendulumMotion, run: Trajectory) -> float:
    """Largest difference of theta [rad] between a run and a closed form."""
    return float(np.abs(run.observables["theta"] - motion.state(run.times)[0]).max())


def _agreement(both: Forms, runs: Runs) -> Table:
    """theta at the end, and how far each stays from either closed form."""
    times = np.linspace(0.0, END, 501)
    off = both.correct.state(times)[0] - both.printed.state(times)[0]
    gap = float(np.abs(off).max())
    rows = [
        row("closed form, correct V", _digits(_end(both.correct)), value(0.0), value(gap)),
        row("closed form, printed V (9)", _digits(_end(both.printed)), value(gap), value(0.0)),
    ]
    for name, run in runs.items():
        from_either = [_distance(motion, run) for motion in (both.correct, both.printed)]
        rows.append(row(name, _digits(_last(run)), *map(value, from_either)))
    heads = ("method", f"θ({END} s) [rad]", "largest distance from the correct form [rad]",
             "from the printed form [rad]")  # fmt: skip
    return Table("Which closed form each method follows", heads, tuple(rows))


def _mutual(both: Forms, runs: Runs) -> Table:
    """Differences of the independent methods at the end, pair by pair."""
    finals = {"closed form": _end(both.correct)} | {n: _last(r) for n, r in runs.items()}
    names = list(finals)
    rows = tuple(
        row(f"{name} – {other}", value(finals[name] - finals[other]))
        for i, name in enumerate(names)
        for other in names[i + 1 :]
    )
    return Table(
        "The independent methods compared with each other",
        ("pair", f"difference of θ({END} s) [rad]"),
        rows,
    )


def _conserved(both: Forms, runs: Runs) -> Table:
    """The variation of each Hamiltonian along the runs."""
    rows = []
    for name, run in runs.items():
        spreads = [
            float(np.ptp(energy(motion.potential, motion.inertia, run)))
            for motion in (both.correct, both.printed)
        ]
        rows.append(row(name, *map(value, spreads)))
    heads = ("along the run of", "correct H varies by [J]", "printed H (9) varies by [J]")
    return Table("What is conserved", heads, tuple(rows))


def _courses(both: Forms, runs: Runs) -> list[Figure]:
    """theta and theta_dot over time: either closed form, and the first independent method."""
    times = np.linspace(0.0, END, 251)
    right, printed = both.correct.state(times), both.printed.state(times)
    figures = []
    for index, (key, name, unit) in enumerate(
        (("theta", "θ", "rad"), ("theta_dot", "dθ/dt", "rad/s"))
    ):
        traces: list[Trace] = [
            curve(times, right[index], colour=BLUE, name="closed form, correct"),
            curve(times, printed[index], colour=RED, dash="dash", name="closed form, printed (9)"),
        ]
        for who, run in list(runs.items())[:1]:
            dots = run.times[::12], run.observables[key][::12]
            traces.append(marks(*dots, GREY, who))
        start = f"θ = {number(both.problem.theta)}, {number(both.problem.theta_dot)} rad/s"
        caption = f"From {start}, on a platform at {number(both.problem.platform_rate)} rad/s."
        figures.append(over_time(f"{name} over time", caption, traces, linear(f"{name} [{unit}]")))
    return figures


def _distances(both: Forms, runs: Runs) -> Figure:
    """Distance of the printed form and of the methods from the correct form, over time."""
    times = np.linspace(0.0, END, 251)[1:]
    off = both.printed.state(times)[0] - both.correct.state(times)[0]
    traces: list[Trace] = [
        curve(times, positive(off), colour=RED, dash="dash", name="closed form, printed (9)")
    ]
    for (name, run), colour in zip(runs.items(), (GREY, PINK), strict=False):
        error = run.observables["theta"] - both.correct.state(run.times)[0]
        traces.append(curve(run.times[1:], positive(error[1:]), colour=colour, name=name))
    return over_time(
        "Distance from the correct closed form",
        "The independent methods differ by their own discretisation error.",
        traces,
        logarithmic("|difference of θ| [rad]"),
        wide=True,
        height=300,
    )


def _digits(angle: float) -> Cell:
    return Cell(f"{angle:.12f}", "number")
