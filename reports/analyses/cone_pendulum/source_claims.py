"""Findings on the source's text: a misprinted inertia, claims on the turning base, an order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.pendulums.harmonics import needed
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.claims import clear
from plumbob.reports.analyses.cone_pendulum import series
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    END,
    MUJOCO,
    MUJOCO_STEP,
    RESTING,
    ROTATING,
    forms,
)
from plumbob.reports.analyses.measurements import (
    case,
    convergence_of,
    extremes,
    order_text,
    scheme,
)
from plumbob.reports.view import notation
from plumbob.reports.view.content import (
    Cell,
    Finding,
    Statement,
    StatementVerdict,
    Table,
    row,
    value,
)
from plumbob.reports.view.notation import number
from plumbob.reports.view.sources import SUDAKOV, as_printed, judged

NEAR = (0.05, 0.10)  # of the initial speed
PARTS = 201  # of a period, among which every extreme of the speed has several
ANGLES = 300  # at which the source's worksheet has V
SAMPLES = 20_000  # over a period: fractions of it to four digits
UNEQUAL = "cone-pendulum/unequal-inertia"
METHOD = "mujoco/euler"  # of the finding on its order
ELSEWHERE = ("no-symmetry", "generating-solution")
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
        row("closed form with the cone's I_x", _digits(with_x), value(with_x - with_y)),
    ]
    text, apart = "the Lagrangian gives the formula with I_y", 0.0
    if engine is not None:
        final = float(engine.observables["theta"][-1])
        rows.append(row("MuJoCo's full model", _digits(final), value(final - with_y)))
        apart = abs(final - with_y)
        text = f"MuJoCo agrees with I_y to {notation.number(apart)} rad"
    table = Table(
        f"A body with I_y = I_x + {notation.number(spread)} kg m²",
        ("motion", f"θ({END} s) [rad]", "difference from the formula with I_y [rad]"),
        tuple(rows),
    )
    return Finding(
        "inertia-y",
        "For a body that is not round, I_y takes the place of the I_x of the source's cone",
        "extended",
        "For a body that is not round use I_y where the paper has the I_x of its cone. "
        f"The source says that any symmetry may be absent; then the error with I_x is "
        f"{notation.number(abs(with_x - with_y))} rad after {END} s, and {text}.",
        (
            "The platform's rotation reaches the body through its moments about y and z, since the "
            "swing is about x: a = ½(I_y – I_z)ω². For the source's cone I_x = I_y, and its (5) to "
            "(9) are right; the source adds that the body may lack any symmetry, and then they "
            "need I_y.",
        ),
        (table,),
        (),
        (f"plumbob run {UNEQUAL} {MUJOCO} --step 1e-4", f"plumbob solve {UNEQUAL} --times {END}"),
        (
            Statement(
                SUDAKOV,
                "(7), (9)",
                "The platform's rotation enters through I_x – I_z",
                f"I_x: θ({END} s) = {with_x:.6f} rad with I_y = I_x + {notation.number(spread)}",
                f"I_y: {with_y:.6f} rad; {text}",
                "extended",
                "right for the cone, of which I_x = I_y",
            ),
        ),
        claims=(
            clear(
                "distances of the printed formula, and of MuJoCo, from that with I_y,",
                with_x - with_y,
                apart,
                "rad",
            ),
        ),
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
    deviation = np.abs(motion.state(times)[1] / motion.theta_dot - 1.0)
    low, high = extremes(lambda t: motion.state(t)[1], np.linspace(0.0, motion.period, PARTS))
    return Speeds(
        low,
        high,
        (high - low) / abs(motion.theta_dot),
        tuple(float((deviation <= near).mean()) for near in NEAR),
    )


def claims(study: Study) -> Finding:
    """Each claim with what the printed formulas give, what is right, and a judgement."""
    resting, turning = forms(RESTING).problem, forms(ROTATING).problem
    same_start = replace(turning, platform_rate=0.0)
    at_rest, right = speeds(resting.motion), speeds(turning.motion)
    printed, level = speeds(forms(ROTATING).printed), speeds(same_start.motion)
    barrier = float(double(turning.motion.barriers[0]))
    barrier_at_rest = float(double(resting.motion.barriers[0]))
    deepest = min(e.potential for e in turning.equilibria)
    top, _ = turning.printed_barrier
    series_terms = needed(turning.motion, series.ACCURACIES)[-1]
    series_near = series.counts(1e-9 * series.barrier())[-1]
    speed, slow = number(turning.theta_dot), number(resting.theta_dot)
    judged_claims = (
        _claim(
            "Fig. 3", "The energy needed to rotate rises to 514.197 J on the turning base",
            "514.197 J", f"{top:.3f} J, the top of the printed V",
            f"{barrier:.3f} J ({barrier_at_rest:.3f} J at rest)",
            "corrected",
            f"It rises, to another number. The source's is the largest of the printed V at "
            f"{ANGLES} equally spaced angles, {sampled_top():.3f} J. The correct V is "
            f"{deepest:.1f} J at its lowest point: that is the depth of the deepest well with the "
            "wrong sign.",
        ),
        _claim(
            "Fig. 3", "A turning base makes the rotation more uniform",
            "more uniform", f"speed spread {_percent(printed.spread)} of the initial {speed} "
            f"rad/s, against {_percent(at_rest.spread)} of {slow} rad/s at rest",
            f"{_percent(right.spread)} ({number(right.lowest, 4)} to {number(right.highest, 4)} "
            "rad/s); "
            f"a resting base from the same {speed} rad/s: {_percent(level.spread)}",
            "corrected",
            "The range of speeds never shrinks; the standard deviation and the time near the "
            "initial speed improve in a regime. See the finding on uniformity.",
            "uniformity",
        ),
        _claim(
            "Fig. 3", "For half of the period the speed stays near its initial value",
            "half of the period", _fractions(printed), _fractions(right),
            "holds" if right.near[0] >= 0.4 else "corrected",
            "By chance: the correct motion satisfies the claim better than the printed one it "
            "comes from.",
        ),
        _claim(
            "(15), (16)", "There is no suitable special function for (15), (16)",
            "none", "–",
            f"T = {number(turning.motion.period, 8)} s and θ(t) by Jacobi functions",
            "refuted",
            "With u = tan(θ/2) the integral is an elliptic one of the first kind, and has a "
            "closed form. See the finding on special functions.",
            "special-functions",
        ),
        _claim(
            "introduction", "Fourier series are simpler and more exact",
            "simpler, more exact", "–",
            f"to 1e-12 {series_terms} harmonics on the motion of Fig. 3, {series_near} at 1e-9 of "
            "the well's depth above the barrier",
            "holds",
            "On the source's own motions; next to the barrier the harmonics needed grow with the "
            "period, without bound. See the finding on special functions.",
            "special-functions",
        ),
        _claim(
            "characteristics", "Any symmetry may be absent",
            "no term for it", "I_x for I_y, no product of inertia", "I_y, and tilted axes",
            "extended", "I_y for I_x, and a product of inertia: see the finding on it.",
            "no-symmetry",
        ),
        _claim(
            "introduction", "The solution can generate others, by perturbation, in electric drives",
            "can", "–", "dI/dt = –ξI with a damped axle",
            "holds", "Also for a drive that is not ideal: see the finding on it.",
            "generating-solution",
        ),
        _claim(
            "terms", "Turning over is called libration, swinging vibration; θ = π the lower point",
            "libration, lower point", "–", "rotation, upper point",
            "corrected",
            "Here, rotation means turning over and libration swinging; θ = 0 hangs down, and "
            "the slowest point of Fig. 2, θ = π, is the upper one.",
        ),
    )  # fmt: skip
    rows = tuple(_texts(claim.text, by_printed, claim.ours, judged(claim))
                 for claim, by_printed in judged_claims)  # fmt: skip
    heads = ("claim", "by the printed formulas", "correct", "judgement")
    return Finding(
        "claims",
        "The source's claims about the turning base, judged",
        "mostly wrong",
        "On a turning platform the pendulum goes over the top more easily than the paper "
        "says, and less uniformly. "
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
        # what another finding computes is a statement of that one
        (*_numbers(), *(claim for claim, _ in judged_claims if claim.finding not in ELSEWHERE)),
    )


def _claim(
    place: str,
    text: str,
    printed: str,
    by_printed: str,
    ours: str,
    verdict: StatementVerdict,
    why: str,
    finding: str = "",
) -> tuple[Statement, str]:
    """A statement of the source, and what its printed formulas give."""
    return Statement(SUDAKOV, place, text, printed, ours, verdict, why, finding), by_printed


def sampled_top() -> float:
    """The largest of the printed V [J] at ANGLES equally spaced angles, as the source finds the
    lower bound of the energy."""
    printed = forms(ROTATING).problem.printed_potential
    a, b, c = (float(double(x)) for x in (printed.a, printed.b, printed.c))
    theta = np.arange(ANGLES) * 2 * np.pi / ANGLES
    return float((-a * np.sin(theta) ** 2 - b * np.sin(theta) - c * np.cos(theta)).max())


def _numbers() -> tuple[Statement, ...]:
    """The numbers that the source prints of its cone and of its two motions."""
    resting, turning = forms(RESTING), forms(ROTATING)
    body = resting.problem.body
    ours = (
        ("(1)", "Mass of the cone", "16.24", body.mass, "kg"),
        ("(1)", "Moment of inertia I_x of the cone", "0.893", body.inertia_x, "kg m²"),
        ("(1)", "Moment of inertia I_z of the cone", "0.031", body.inertia_z, "kg m²"),
        ("Fig. 2", "Barrier on a platform at rest", "35.809",
         float(double(resting.correct.barriers[0])), "J"),
        ("Fig. 2", "H₀ at θ̇₀ = 13 rad/s on a platform at rest", "39.624",
         _start_energy(resting.correct), "J"),
        ("Fig. 3", f"Top of the printed V at {ANGLES} angles, the lower bound of H₀", "514.197",
         sampled_top(), "J"),
        ("Fig. 3", "H₀ at θ̇₀ = 37 rad/s on the platform at 26 rad/s", "575.246",
         _start_energy(turning.correct), "J"),
    )  # fmt: skip
    return tuple(as_printed(SUDAKOV, *numbers) for numbers in ours)


def _start_energy(motion: PendulumMotion) -> float:
    """H [J] at the start."""
    return float(double(motion.energy))


def _texts(*texts: str) -> tuple[Cell, ...]:
    return tuple(Cell(text, "text") for text in texts)


def _percent(value: float) -> str:
    return f"{100 * value:.0f} %"


def _fractions(speeds: Speeds) -> str:
    each = (
        f"{_percent(part)} of the period within {_percent(near)}"
        for part, near in zip(speeds.near, NEAR, strict=True)
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
        series = convergence_of(study, name, METHOD)
        order = order_text(series.order) if series and series.order else "not measured"
        rows.append(row(name, *(value(v, 4) for v in (start, size[1], size[2])), order))
    heads = ("scene", "a(θ₀) [rad/s²]", "largest |C₁| [rad/s]", "largest |C₂| [rad/s²]",
             f"observed order of {METHOD}")  # fmt: skip
    return Finding(
        "euler-order",
        "Euler is of second order when it starts at the bottom on a resting base",
        "confirmed",
        "A test of Euler that starts hanging straight down on a resting base shows one order "
        "too many: start elsewhere. "
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
