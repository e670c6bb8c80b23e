"""Eq. 31 over the whole of a turn, and the source's Fig. 3: angles in time, and the path of C."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.capsule_turn.turns import JUDGED, name_of, turn
from plumbob.reports.analyses.measurements import covers, problem
from plumbob.reports.view.content import Figure, Finding, Statement, Table, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import BLUE, GREY, OF_METHODS, OLIVE, PERIWINKLE, RED
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import Trace, curve, figure, linear, marks

DRAWN = 0.3  # epsilon of the figures: friction is seen there
EPSILONS, COLOURS = (0.3, 0.1, 0.03), (RED, OLIVE, PERIWINKLE)
ENGINES = (("mujoco/rk4+coulomb", "MuJoCo"), ("pymunk/feet", "pymunk"))
POINTS, DOTS, LASTING = 400, 16, 3.0  # of a curve, of a run, and half times


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The turn that is drawn, with both engines, at the step judged."""
    return [_run(method) for method, _ in ENGINES] if covers(plan, name_of(DRAWN)) else ()


def _run(method: str) -> ExtraRun:
    return ExtraRun(name_of(DRAWN), method, turn(DRAWN).half_time / JUDGED)


def course(epsilon: float, phases: Array) -> tuple[Array, Array]:
    """psi [rad], shape (n,), and the place of C [m], shape (n, 2), of the exact motion at times
    `phases` tau, shape (n,)."""
    pose = problem(name_of(epsilon)).motion.single.at(phases * turn(epsilon).half_time)
    return pose.heading, pose.position


def leading_path(manoeuvre: TurnManoeuvre, phases: Array) -> Array:
    """Place of C [m], shape (n, 2), to leading order: it goes round the combined centre, which
    stays where it is."""
    times = phases * manoeuvre.half_time
    arm = manoeuvre.capsule.mass_ratio * manoeuvre.radius * np.exp(1j * manoeuvre.start)
    moved = arm - arm * np.exp(1j * (manoeuvre.slider_angles(times) + manoeuvre.body_angles(times)))
    return np.column_stack([moved.real, moved.imag])


def departure(epsilon: float) -> tuple[float, float]:
    """Largest |psi + mu_1 phi| over (0, 2 tau) [rad], and its time over tau."""
    phases = np.linspace(0.0, 2.0, POINTS + 1)
    psi, _ = course(epsilon, phases)
    off = np.abs(psi - turn(epsilon).body_angles(phases * turn(epsilon).half_time))
    return float(off.max()), float(phases[np.argmax(off)])


def finding(study: Study) -> Finding | None:
    """How far psi is from -mu_1 phi during a turn; None where no turn is in the study."""
    runs = {
        method: run
        for method, _ in ENGINES
        if covers(study, name_of(DRAWN)) and (run := study.recording(_run(method))) is not None
    }
    rows = []
    for epsilon in EPSILONS:
        off, when = departure(epsilon)
        rows.append(row(value(epsilon), value(off), value(off / epsilon**2, 4), value(when)))
    off, _ = departure(DRAWN)
    heads = ("ε", "largest |ψ + μ₁φ| on (0, 2τ) [rad]", "over ε²", "at t/τ")
    return Finding(
        "capsule-turn-course",
        "Eq. 31, ψ = –μ₁φ, over the whole of a turn and not at its end alone",
        "confirmed",
        "The formula may be used during a turn, and not at its end alone. "
        f"At ε = {number(DRAWN)} the body is never further than {number(off)} rad from –μ₁φ while "
        "the slider moves, and the difference falls as ε²; it is largest when the slider stops.",
        (
            "φ is the slider's angle about C, ψ the body's. Friction turns the body back all the "
            "time, so the difference grows throughout (0, 2τ), and for a while after, when the "
            "residual motion goes the same way. C goes round the combined centre of mass, which "
            "without friction would stay where it is: the dashed arc.",
        ),
        (Table("ψ less –μ₁φ", heads, tuple(rows)),),
        (_angles(runs), _departures(), _path(runs)),
        (f"plumbob solve capsule-turn/{DRAWN}",
         f"plumbob run capsule-turn/{DRAWN} {ENGINES[0][0]} "
         f"--step {turn(DRAWN).half_time / JUDGED:.17g}"),
        (
            Statement(
                CHERNOUSKO,
                "(31), Fig. 3",
                "ψ(t) = –μ₁φ(t) on (0, 2τ)",
                "–μ₁φ(t), to leading order",
                f"within {number(off)} rad at ε = {number(DRAWN)}, falling as ε²",
                "holds",
            ),),
    )  # fmt: skip


def _angles(runs: dict[str, Trajectory]) -> Figure:
    manoeuvre, phases = turn(DRAWN), np.linspace(0.0, LASTING, POINTS)
    times = phases * manoeuvre.half_time
    psi, _ = course(DRAWN, phases)
    traces: list[Trace] = [
        curve(phases, manoeuvre.slider_angles(times), colour=BLUE, name="φ"),
        curve(phases, manoeuvre.body_angles(times), colour=GREY, dash="dash", name="–μ₁φ"),
        curve(phases, psi, colour=RED, width=2.2, name="ψ, exact"),
    ]
    for place, (method, shown) in enumerate(ENGINES):
        if (run := runs.get(method)) is not None:
            kept = _dots(run, place)
            dots = run.times[kept] / manoeuvre.half_time, run.observables["body_angle"][kept]
            traces.append(marks(*dots, OF_METHODS[method], shown))
    return figure(
        "Angles of slider and body",
        f"ε = {number(DRAWN)}; the slider stops at 2τ. Marks: steps of τ/{JUDGED}.",
        traces,
        linear("t/τ"),
        linear("angle [rad]"),
        legend=True,
        height=300,
    )


def _departures() -> Figure:
    phases = np.linspace(0.0, LASTING, POINTS)
    traces: list[Trace] = []
    for epsilon, colour in zip(EPSILONS, COLOURS, strict=True):
        psi, _ = course(epsilon, phases)
        off = psi - turn(epsilon).body_angles(phases * turn(epsilon).half_time)
        traces.append(curve(phases, off / epsilon**2, colour=colour, name=f"ε = {number(epsilon)}"))
    return figure(
        "What eq. 31 leaves out, over ε²",
        "One curve for all small ε until 2τ: the next order.",
        traces,
        linear("t/τ"),
        linear("(ψ + μ₁φ)/ε² [rad]"),
        legend=True,
        height=300,
    )


def _path(runs: dict[str, Trajectory]) -> Figure:
    phases = np.linspace(0.0, LASTING, POINTS)
    _, place = course(DRAWN, phases)
    leading = leading_path(turn(DRAWN), np.minimum(phases, 2.0))
    traces: list[Trace] = [
        curve(*(1e3 * leading.T), colour=GREY, dash="dash", name="without friction"),
        curve(*(1e3 * place.T), colour=RED, width=2.2, name="exact"),
    ]
    for number_, (method, shown) in enumerate(ENGINES):
        if (run := runs.get(method)) is not None:
            kept = _dots(run, number_)
            x, y = (1e3 * run.observables[name][kept] for name in ("x", "y"))
            traces.append(marks(x, y, OF_METHODS[method], shown))
    return figure(
        "Path of C",
        f"ε = {number(DRAWN)}, from the start at 0, 0.",
        traces,
        linear("x [mm]"),
        linear("y [mm]", scaleanchor="x"),
        legend=True,
        height=340,
    )


def _dots(run: Trajectory, place: int) -> Array:
    """Samples evenly spaced over the turn, those of the engines in turn."""
    inside = np.flatnonzero(run.times <= LASTING * turn(DRAWN).half_time)
    every = max(1, len(inside) // DOTS)
    return np.asarray(inside[place * every // 2 :: every])
