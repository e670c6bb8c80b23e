"""Findings on the references: how long they are known, and what rounding does next to the top."""

from __future__ import annotations

import math
from types import MappingProxyType

import numpy as np

from plumbob.analytic.numerics.quad import PI, double, quad
from plumbob.analytic.numerics.rotor.lyapunov import LyapunovExponent, largest_exponent
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.analytic.systems.pendulums.unending_motion import UnendingMotion
from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.analyses.measurements import case
from plumbob.reports.analyses.saddle_growth import Saddle, saddle_growth
from plumbob.reports.analyses.simple_pendulum.notebook import CASES, FORCED, SIMPLE
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Figure, Finding, Table, row, value
from plumbob.reports.view.palette import BLUE, GREY, RED
from plumbob.reports.view.traces import curve, logarithmic, over_time, positive

CHAOTIC = f"{SIMPLE}forced-chaotic"
SPAN, LONG = 50.0, 180.0  # [s]
HORIZONS = (1e-12, 1e-9, 1e-6)  # [rad]
AGREED = 3e-12  # [rad] within which two methods must agree over SPAN
FOLLOWED = MappingProxyType(
    {"quick": 300.0, "full": 2000.0}
)  # [s] that the Lyapunov exponent is averaged over
EXPONENTS = (1, 2, 3, 4, 5, 6, 8, 10, 12)
TIMES = 101  # over a period


def references(study: Study) -> Finding:
    """Agreement of two methods on each scene, and the horizon of the chaotic one."""
    every = [name for name in CASES.values() if "damped" in name] + list(FORCED)
    chosen = {scene.name for scene in study.scenes} | {CHAOTIC, SIMPLE + "damped-rotating"}
    names = [n for n in every if study.profile == "full" or SIMPLE + n in chosen]
    rows = []
    for name in names:
        motion = _followed(SIMPLE + name, LONG if SIMPLE + name == CHAOTIC else SPAN)
        at, gaps = motion.disagreement
        doubt = motion.uncertainty(at[at <= SPAN])["theta"]
        apart = float(gaps["theta"][at <= SPAN].max())
        rows.append(row(name, value(apart), value(float(doubt.max())),
                        Cell(f"{notation.short(HORIZONS[0])} rad {_until(motion)}")))  # fmt: skip
    motion = _followed(CHAOTIC, LONG)
    exponent = _exponent(study.profile)
    at, gaps = motion.disagreement
    beyond = np.flatnonzero(gaps["theta"] > AGREED)
    separated = float(at[beyond[0]]) if beyond.size else np.inf
    horizons = {tolerance: motion.horizon(tolerance) for tolerance in HORIZONS}
    limits = ", ".join(f"{notation.short(x)} rad for {t:.0f} s" for x, t in horizons.items())
    return Finding(
        "references",
        "Damped and forced pendulums: no formula, two methods that agree, and a limit set by chaos",
        "measured",
        "Damped and forced pendulums have no formula, and their reference is still certain, "
        "for as long as chaos allows. "
        f"Taylor series and Gauss collocation agree on θ to {AGREED:g} rad for 50 s in every "
        f"scene, and in the chaotic one for {separated:.0f} s. A start and parameters in double "
        f"precision determine its θ to {limits}; no method in double precision does better.",
        (
            "A non-linear pendulum with damping or forcing has no closed form. The reference is a "
            "Taylor series of high order; the second, independent method is Gauss collocation. The "
            "error bar is the larger of their difference and of the effect of one unit in the last "
            "place of every input. Undamped motions are Jacobi functions, and linear ones have a "
            "closed form.",
            f"In {CHAOTIC} neighbouring motions separate as e^(λt), with λ = {exponent.value:.3f} "
            f"± {exponent.standard_error:.3f}/s (mean over {FOLLOWED[study.profile]:.0f} s after "
            "100 s of transient; one standard error). The scene is run for 50 s. Any comparison "
            "beyond the horizon compares round-off.",
        ),
        (
            Table(
                "How well the reference is known over 50 s",
                ("scene", "difference of two methods [rad]", "error bar [rad]", "known to"),
                tuple(rows),
                "Largest over the run. The error bar may shrink where neighbouring motions meet.",
            ),
        ),
        (_plot(motion, exponent),),
        (
            f"plumbob solve {CHAOTIC} --times 10,20,30,40,50",
            f"plumbob validate --scenes {CHAOTIC} --methods ode/dop853,ode/lsoda,mujoco/rk4",
        ),
    )


def _followed(name: str, until: float) -> DrivenMotion:
    rotor, problem = case(name).problem.rotor, case(name).problem
    return UnendingMotion(rotor, problem.theta, problem.theta_dot).until(until)


def _until(motion: DrivenMotion) -> str:
    horizon = motion.horizon(HORIZONS[0])
    return f"for {horizon:.0f} s" if np.isfinite(horizon) else "for all times"


def _exponent(profile: str) -> LyapunovExponent:
    problem = case(CHAOTIC).problem
    return largest_exponent(problem.rotor, problem.theta, problem.theta_dot, FOLLOWED[profile])


def _plot(motion: DrivenMotion, exponent: LyapunovExponent) -> Figure:
    at, gaps = motion.disagreement
    times = np.linspace(0.0, LONG, 300)[1:]
    doubt = motion.uncertainty(times)["theta"]
    foot = 1e-15 * np.exp(exponent.value * times)
    return over_time(
        "The horizon of the chaotic pendulum",
        "Dotted: the effect of rounding each input. On average it grows as e^(λt), and it passes "
        "1e-12 rad at "
        + " and 1e-9 rad at ".join(f"{motion.horizon(x):.0f} s" for x in HORIZONS[:2])
        + ".",
        [
            curve(at[1:], positive(gaps["theta"][1:]), colour=BLUE, name="two methods' difference"),
            curve(times, positive(doubt), colour=GREY, dash="dot", width=2.0,
                  name="error bar"),
            curve(times, foot, colour=RED, dash="dash",
                  name=f"e^(λt), λ = {exponent.value:.3f}/s"),
        ],
        logarithmic("|difference of θ| [rad]"),
        wide=True,
        height=320,
    )  # fmt: skip


def near_top(study: Study) -> Finding:
    """The complement of the angle as the argument, against scipy and against the rounded angle."""
    rows = tuple(_row(k) for k in EXPONENTS)
    lost, gap = _scipy(5), _rounded(12)[2]
    return Finding(
        "near-top",
        "Next to the top the angle is a poor input: its distance from the top is a good one",
        "measured",
        "Give a start next to the top as a distance from the top: as an angle it loses its "
        "digits. "
        f"From π – 1e-5 the error of θ by scipy's ellipj is {notation.number(lost)} rad within a "
        f"period; from π – 1e-12 as a double the motion differs by up to "
        f"{notation.number(gap)} rad from the one asked for. With theta_from_top as the input the "
        "period keeps 15 digits.",
        (
            "The usual θ = 2 arcsin(k sn(K – ωt | m)) has m = sin²(θ₀/2): 1 – 2.5e-11 at 1e-5; "
            "it rounds to 1 from 1e-8 on, and ellipj loses its period before that. The "
            "closed form here starts from the distance to the top, in 34 digits, and uses "
            "arithmetic–geometric means of the complementary parameter.",
            "No engine has such an input. Doubles near π are 4.4e-16 rad apart, so an engine asked "
            "for π – 1e-12 starts with a relative error of that distance of up to 2.2e-4, and is "
            "early or late by that over the rate √(g/L). The exact answer is that of the distance "
            "asked for; its error bar includes the effect of rounding the start, and of rounding "
            "θ again in each step.",
        ),
        (
            Table(
                "From rest at π – 10⁻ᵏ, over one period",
                ("k", "period [s]", "relative error of scipy's period", "error of scipy's θ [rad]",
                 "relative error of the distance as a double", "of its period",
                 "error of its θ [rad]"),
                rows,
                "scipy: ellipk and ellipj of m = sin²(θ₀/2). Errors: against the closed form from "
                "theta_from_top, which tests compare with 60-digit quadrature.",
            ),
        ),
        (),
        (
            f"plumbob solve {SIMPLE}near-top-1e-12",
            f"plumbob run {SIMPLE}near-top-1e-12 ode/dop853 --step 1e-13",
        ),
    )  # fmt: skip


def _posed(k: int) -> tuple[SimplePendulum, PendulumMotion, Array]:
    """The problem of a start 10^-k from the top, its exact motion, and times over its period."""
    problem: SimplePendulum = case(f"{SIMPLE}near-top-1e-{k}").problem
    motion = problem.elliptic
    assert motion is not None
    return problem, motion, np.linspace(0.0, motion.period, TIMES)


def _row(k: int) -> tuple[Cell, ...]:
    _, motion, _ = _posed(k)
    period = _by_scipy(k, np.zeros(1))[1] / motion.period - 1
    return row(Cell(str(k), "number"), value(motion.period, 16),
               _or_nan(period), _or_nan(_scipy(k)),
               *(value(v, 2) for v in _rounded(k)))  # fmt: skip


def _or_nan(error: float) -> Cell:
    return value(error, 2) if math.isfinite(error) else Cell("not a number", "number")


def _by_scipy(k: int, times: Array) -> tuple[Array, float]:
    """theta [rad] at `times` [s], shape (n,), and the period [s], by the textbook's formula."""
    import scipy.special

    problem, _, _ = _posed(k)
    rate = math.sqrt(problem.gravity / problem.length)
    parameter = math.sin(problem.started.theta / 2) ** 2
    quarter = float(scipy.special.ellipk(parameter))
    with np.errstate(invalid="ignore"):
        sn = scipy.special.ellipj(quarter - rate * times, parameter)[0]
    return 2 * np.arcsin(math.sqrt(parameter) * sn), 4 * quarter / rate


def _scipy(k: int) -> float:
    """Largest error of theta [rad] over a period by scipy's functions."""
    _, motion, times = _posed(k)
    return float(np.abs(_by_scipy(k, times)[0] - motion.observe(times)["theta"]).max())


def _rounded(k: int) -> tuple[float, float, float]:
    """The effect of the angle as a double: relative change of the distance from the top and of the
    period, and largest change of theta [rad] over a period."""
    problem, motion, times = _posed(k)
    beside = problem.started.elliptic
    assert beside is not None
    distance = float(double(PI - quad(problem.started.theta)))
    gap = np.abs(beside.observe(times)["theta"] - motion.observe(times)["theta"]).max()
    return (
        distance / -(problem.theta_from_top or math.nan) - 1,
        beside.period / motion.period - 1,
        float(gap),
    )


def hard(study: Study, scene: Scene) -> tuple[Figure | Table, ...]:
    """Growth of the errors at the top, which leaves it at sqrt(g/L)."""
    problem: SimplePendulum = case(scene.name).problem
    motion = problem.started.elliptic  # the one whose roundings an engine has
    if motion is None:
        return ()
    top = Saddle(math.pi, math.sqrt(problem.gravity / problem.length))
    note = (
        "The motion starts here, and the error that each step adds is proportional to the distance "
        "from the top: it accumulates as t e^(λt), whose fitted rate is above λ by about 1/t. The "
        "effect of rounding the start grows as e^(λt)."
    )
    return saddle_growth(study, scene, motion, top, note)
