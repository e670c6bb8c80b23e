"""The finding that the printed Hamiltonian (9) contradicts the Lagrangian (7) it is made from."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.findings.cone_pendulum.problems import (
    BLACK,
    BLUE,
    LAGRANGE,
    LAGRANGE_RTOL,
    MUJOCO,
    MUJOCO_STEP,
    PINK,
    RED,
    ROTATING,
    Case,
    case,
)
from plumbob.reports.findings.energy_drift import energy
from plumbob.reports.findings.fresh_runs import run
from plumbob.reports.view.content import Cell, Figure, Finding, Table, row
from plumbob.reports.view.notation import number
from plumbob.reports.view.traces import Trace, curve, figure, linear, logarithmic, positive

END = 0.5  # [s]
Held = Mapping[str, Trajectory]


def finding() -> Finding:
    """Three curves, three witnesses, and what each Hamiltonian does along their runs."""
    both = case(ROTATING)
    witnesses = {
        "MuJoCo's full model": run(ROTATING, MUJOCO, MUJOCO_STEP, END),
        "the equation of (7), integrated": run(ROTATING, LAGRANGE, LAGRANGE_RTOL, END),
    }
    held = {name: found for name, found in witnesses.items() if found is not None}
    gap = abs(_end(both.printed) - _end(both.correct))
    worst = max((_distance(both.correct, found) for found in held.values()), default=0.0)
    paragraphs = (
        "With the platform's rate prescribed, the conserved quantity is the Legendre transform of "
        "the Lagrangian, p dθ/dt – L = p²/2I + V with V = –a sin²θ – b sin θ – c cos θ (the Jacobi "
        "integral). The source prints a sin²θ + b sin θ – c cos θ: the centrifugal terms with the "
        "opposite sign. Eqs. 15 and 16 and the whole of Fig. 3 inherit it. On a platform at rest "
        "a = b = 0 and the two agree, so Fig. 2 stands.",
        "Three witnesses that share no code: MuJoCo steps a multibody model of platform, hinge and "
        "cone, and knows no Hamiltonian; DOP853 integrates Lagrange's equation of (7); the closed "
        "form inverts the elliptic integral of the corrected one.",
    )
    return Finding(
        "printed-hamiltonian",
        "The printed Hamiltonian (9) contradicts the source's own Lagrangian (7)",
        "contradicted",
        f"Eq. 9 is T + U, which a prescribed rotation does not conserve. After {END} s the motion "
        f"it describes is {number(gap)} rad away from the motion of eq. 7, which MuJoCo and an "
        f"integrated Lagrange equation follow to {number(worst)} rad.",
        paragraphs,
        (_witnesses(both, held), _mutual(both, held), _conserved(both, held)),
        (*_courses(both, held), _distances(both, held)),
        (
            f"plumbob run {ROTATING} {MUJOCO} --step 1e-4",
            f"plumbob run {ROTATING} {LAGRANGE} --step 1e-13",
            f"plumbob solve {ROTATING} --times {END}",
        ),
    )


def _end(motion: PendulumMotion) -> float:
    return float(motion.state(np.array([END]))[0][0])


def _last(found: Trajectory) -> float:
    return float(found.observables["theta"][-1])


def _distance(motion: PendulumMotion, found: Trajectory) -> float:
    """Largest difference of theta [rad] between a run and a closed form."""
    return float(np.abs(found.observables["theta"] - motion.state(found.times)[0]).max())


def _witnesses(both: Case, held: Held) -> Table:
    """theta at the end, and how far each stays from either closed form."""
    times = np.linspace(0.0, END, 501)
    off = both.correct.state(times)[0] - both.printed.state(times)[0]
    gap = float(np.abs(off).max())
    rows = [
        row("closed form, correct V", _digits(_end(both.correct)), _cell(0.0), _cell(gap)),
        row("closed form, printed V (9)", _digits(_end(both.printed)), _cell(gap), _cell(0.0)),
    ]
    for name, found in held.items():
        from_either = [_distance(motion, found) for motion in (both.correct, both.printed)]
        rows.append(row(name, _digits(_last(found)), *map(_cell, from_either)))
    heads = ("witness", f"θ({END} s) [rad]", "largest distance from the correct form [rad]",
             "from the printed form [rad]")  # fmt: skip
    return Table("Who follows which", heads, tuple(rows))


def _mutual(both: Case, held: Held) -> Table:
    """Differences of the witnesses at the end, pair by pair."""
    finals = {"closed form": _end(both.correct)} | {n: _last(r) for n, r in held.items()}
    names = list(finals)
    rows = tuple(
        row(f"{one} – {other}", _cell(finals[one] - finals[other]))
        for i, one in enumerate(names)
        for other in names[i + 1 :]
    )
    return Table("The witnesses among themselves", ("pair", f"θ({END} s) differs by [rad]"), rows)


def _conserved(both: Case, held: Held) -> Table:
    """What each Hamiltonian does along the runs."""
    rows = []
    for name, found in held.items():
        spreads = [
            float(np.ptp(energy(motion.potential, motion.inertia, found)))
            for motion in (both.correct, both.printed)
        ]
        rows.append(row(name, *map(_cell, spreads)))
    heads = ("along the run of", "correct H varies by [J]", "printed H (9) varies by [J]")
    return Table("What is conserved", heads, tuple(rows))


def _courses(both: Case, held: Held) -> list[Figure]:
    """theta and theta_dot over time: either closed form, and the first witness as dots."""
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
        for who, found in list(held.items())[:1]:
            dots = found.times[::12], found.observables[key][::12]
            traces.append(curve(*dots, colour=BLACK, marks=True, lines=False, name=who))
        start = f"θ = {number(both.problem.theta)}, {number(both.problem.theta_dot)} rad/s"
        caption = f"From {start}, on a platform at {number(both.problem.platform_rate)} rad/s."
        axes = linear("time [s]"), linear(f"{name} [{unit}]")
        figures.append(figure(f"{name} over time", caption, traces, *axes, legend=True))
    return figures


def _distances(both: Case, held: Held) -> Figure:
    """How far the printed form and the witnesses are from the correct form, over time."""
    times = np.linspace(0.0, END, 251)[1:]
    off = both.printed.state(times)[0] - both.correct.state(times)[0]
    traces: list[Trace] = [
        curve(times, positive(off), colour=RED, dash="dash", name="closed form, printed (9)")
    ]
    for (name, found), colour in zip(held.items(), (BLACK, PINK), strict=False):
        own = found.observables["theta"] - both.correct.state(found.times)[0]
        traces.append(curve(found.times[1:], positive(own[1:]), colour=colour, name=name))
    return figure(
        "Distance from the correct closed form",
        "What remains of the witnesses is their own discretisation.",
        traces,
        linear("time [s]"),
        logarithmic("|difference of θ| [rad]"),
        legend=True,
        wide=True,
        height=300,
    )


def _digits(value: float) -> Cell:
    return Cell(f"{value:.12f}", "number")


def _cell(value: float) -> Cell:
    return Cell(number(value), "number")
