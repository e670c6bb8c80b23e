"""Findings on the source's text: a misprinted inertia, claims on the turning base, an order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.findings.cone_pendulum.hamiltonian import (
    END,
    MUJOCO,
    MUJOCO_STEP,
    RESTING,
    ROTATING,
    forms,
)
from plumbob.reports.findings.measurements import case, convergence_of, order_text, scheme
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Finding, Table, row, value
from plumbob.reports.view.notation import number

NEAR = (0.05, 0.10)  # of the initial speed
SAMPLES = 20_000  # over a period: fractions of it to four digits
UNEQUAL = "cone-pendulum/unequal-inertia"
METHOD = "mujoco/euler"  # of the finding on its order
ZERO = 1e-12  # [s], of C₁ over C₂: rounding alone


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """MuJoCo's full model of a body without symmetry."""
    return (ExtraRun(UNEQUAL, MUJOCO, MUJOCO_STEP, END),)


def inertia(study: Study) -> Finding:
    """MuJoCo against the formula with I_y and with the printed I_x."""
    problem = case(UNEQUAL).problem
    body = problem.body
    printed = replace(problem, body=replace(body, inertia_y=body.inertia_x))
    at = np.array([END])
    with_y, with_x = (float(p.motion.state(at)[0][0]) for p in (problem, printed))
    engine = study.recording(ExtraRun(UNEQUAL, MUJOCO, MUJOCO_STEP, END))
    spread = body.inertia_y - body.inertia_x
    rows = [
        row("closed form with I_y", _digits(with_y), ""),
        row("closed form with the printed I_x", _digits(with_x), value(with_x - with_y)),
    ]
    said = "the Lagrangian gives the formula with I_y"
    if engine is not None:
        final = float(engine.observables["theta"][-1])
        rows.append(row("MuJoCo's full model", _digits(final), value(final - with_y)))
        said = f"MuJoCo agrees with I_y to {notation.number(abs(final - with_y))} rad"
    table = Table(
        f"A body with I_y = I_x + {notation.number(spread)} kg m²",
        ("motion", f"θ({END} s) [rad]", "difference from the formula with I_y [rad]"),
        tuple(rows),
    )
    return Finding(
        "inertia-y",
        "Where the source prints I_x, its Lagrangian needs I_y",
        "misprint",
        f"The source says that any symmetry may be absent; then the error with the printed "
        f"I_x is {notation.number(abs(with_x - with_y))} rad after {END} s, and {said}.",
        (
            "The platform's rotation reaches the body through its moments about y and z, since the "
            "swing is about x: a = ½(I_y – I_z)ω². For a cone I_x = I_y, and there is no "
            "difference; the source adds that the body may lack any symmetry, and then there is.",
        ),
        (table,),
        (),
        (f"plumbob run {UNEQUAL} {MUJOCO} --step 1e-4", f"plumbob solve {UNEQUAL} --times {END}"),
    )


@dataclass(frozen=True)
class Speeds:
    """How uniform a rotation is: its speeds over one period, relative to the initial one."""

    lowest: float  # [rad/s]
    highest: float
    spread: float  # over the initial speed
    near: tuple[float, ...]  # fractions of the period within each of NEAR of the initial speed


def speeds(motion: PendulumMotion) -> Speeds:
    """Speeds of a rotation over one period."""
    times = (np.arange(SAMPLES) + 0.5) * motion.period / SAMPLES
    rate = motion.state(times)[1]
    deviation = np.abs(rate / motion.theta_dot - 1.0)
    return Speeds(
        float(rate.min()),
        float(rate.max()),
        float(np.ptp(rate) / abs(motion.theta_dot)),
        tuple(float((deviation <= near).mean()) for near in NEAR),
    )


def claims() -> Finding:
    """Each claim with what the printed formulas give, what is right, and a judgement."""
    resting, turning = forms(RESTING).problem, forms(ROTATING).problem
    same_start = replace(turning, platform_rate=0.0)
    at_rest, right = speeds(resting.motion), speeds(turning.motion)
    printed, level = speeds(forms(ROTATING).printed), speeds(same_start.motion)
    barrier = float(double(turning.motion.barriers[0]))
    barrier_at_rest = float(double(resting.motion.barriers[0]))
    deepest = min(e.potential for e in turning.equilibria)
    top, _ = turning.printed_barrier
    speed, slow = number(turning.theta_dot), number(resting.theta_dot)
    rows = (
        _texts(
            "The energy needed to rotate rises to 514.197 J on the turning base",
            f"{top:.3f} J, the top of the printed V",
            f"{barrier:.3f} J ({barrier_at_rest:.3f} J at rest)",
            _judged(
                "wrong",
                f"The correct V is {deepest:.1f} J at its lowest point: the printed number is the "
                f"depth of the deepest well with the wrong sign.",
            ),
        ),
        _texts(
            "A turning base makes the rotation more uniform",
            f"speed spread {_percent(printed.spread)} of the initial {speed} rad/s, against "
            f"{_percent(at_rest.spread)} of {slow} rad/s at rest",
            f"{_percent(right.spread)} ({number(right.lowest, 4)} to {number(right.highest, 4)} "
            "rad/s); "
            f"a resting base from the same {speed} rad/s: {_percent(level.spread)}",
            _judged(
                "split",
                "The range of speeds never shrinks; the standard deviation and the time near the "
                "initial speed improve in a regime. See the finding on uniformity.",
            ),
        ),
        _texts(
            "For half of the period the speed stays near its initial value",
            _fractions(printed),
            _fractions(right),
            _judged(
                "right, by chance" if printed.near[0] < 0.4 <= right.near[0] else "see figures",
                "The correct motion satisfies the claim better than the printed one it comes from.",
            ),
        ),
        _texts(
            "There is no suitable special function for (15), (16)",
            "–",
            f"T = {number(turning.motion.period, 8)} s and θ(t) by Jacobi functions",
            _judged(
                "refuted",
                "With u = tan(θ/2) the integral is an elliptic one of the first kind, and has a "
                "closed form. See the finding on special functions.",
            ),
        ),
        _texts(
            "Fourier series are simpler and more exact",
            "–",
            "–",
            _judged(
                "refuted near a separatrix",
                "The harmonics needed grow with the period, without bound. See the same finding.",
            ),
        ),
        _texts(
            "Any symmetry may be absent",
            "I_x for I_y, no product of inertia",
            "I_y, and tilted axes",
            _judged("extended", "I_y for I_x, and a product of inertia: see the finding on it."),
        ),
        _texts(
            "The solution can generate others, by perturbation, in electric drives",
            "–",
            "dI/dt = –ξI with a damped axle",
            _judged("right", "Also for a drive that is not ideal: see the finding on it."),
        ),
        _texts(
            "Turning over is called libration, swinging vibration; θ = π the lower point",
            "–",
            "–",
            _judged(
                "terms",
                "Here, rotation means turning over and libration swinging; θ = 0 hangs down, and "
                "the slowest point of Fig. 2, θ = π, is the upper one.",
            ),
        ),
    )
    heads = ("claim", "by the printed formulas", "correct", "judgement")
    return Finding(
        "claims",
        "The source's claims about the turning base, judged",
        "mostly wrong",
        f"The barrier is {barrier:.3f} J, not 514.197 J. In the source's own example the turning "
        f"base makes the rotation less uniform (a spread of {_percent(right.spread)} instead of "
        f"{_percent(level.spread)} from the same speed), not more.",
        (),
        (Table("Claim by claim", heads, rows),),
        (),
        (
            f"plumbob solve {ROTATING}",
            f"plumbob solve {RESTING}",
            f"plumbob solve {ROTATING} --set platform_rate=0",
        ),
    )


def _texts(*texts: str) -> tuple[Cell, ...]:
    return tuple(Cell(text, "text") for text in texts)


def _judged(word: str, why: str) -> str:
    return f"{word}: {why}"


def _percent(value: float) -> str:
    return f"{100 * value:.0f} %"


def _fractions(found: Speeds) -> str:
    each = (
        f"{_percent(part)} of the period within {_percent(near)}"
        for part, near in zip(found.near, NEAR, strict=True)
    )
    return ", ".join(each)


def euler_order(study: Study) -> Finding:
    """The leading coefficients on both bases, and the orders that the study saw."""
    rows, first = [], {}
    for name in (RESTING, ROTATING):
        problem = forms(name).problem
        rotor = problem.motion.rotor
        duration = next((s.duration for s in study.scenes if s.name == name), 0.5)
        times = np.linspace(0.0, duration, 200)
        terms = case(name).errors.series(scheme(METHOD), times)
        size = {p: float(np.abs(terms[p]["theta"]).max()) for p in (1, 2)}
        if size[1] < ZERO * size[2]:  # what rounding leaves of it differs from process to process
            size[1] = 0.0
        first[name] = size[1]
        start = float(rotor.acceleration(0.0, problem.theta, problem.theta_dot))
        found = convergence_of(study, name, METHOD)
        seen = order_text(found.order) if found and found.order else "not measured"
        rows.append(row(name, *(value(v, 4) for v in (start, size[1], size[2])), seen))
    heads = ("scene", "a(θ₀) [rad/s²]", "largest |C₁| [rad/s]", "largest |C₂| [rad/s²]",
             f"observed order of {METHOD}")  # fmt: skip
    return Finding(
        "euler-order",
        "Euler is of second order when it starts at the bottom on a resting base",
        "confirmed",
        f"Semi-implicit Euler is leapfrog with the velocity shifted by half a step. The shift is "
        f"½h a(θ₀), and hanging straight down a(θ₀) = 0 on a resting base: the first-order term C₁ "
        f"{_size(first[RESTING], first[ROTATING])} there and is {notation.number(first[ROTATING])} "
        f"rad/s on the turning one.",
        (
            "The order of a method thus depends on the motion and on the observable too: a test "
            "that starts at the bottom of a swing would certify a first-order integrator as second "
            "order.",
        ),
        (Table("Leading coefficients, error = C₁h + C₂h² + …", heads, tuple(rows)),),
        (),
        (f"plumbob validate --scenes {RESTING},{ROTATING} --methods {METHOD}",),
    )


def _size(value: float, beside: float) -> str:
    return "vanishes" if value < 1e-9 * beside else f"is {notation.number(value)} rad/s"


def _digits(angle: float) -> Cell:
    return Cell(f"{angle:.9f}", "number")
