"""How far the exact answers of damped and forced pendulums are to be trusted, and for how long."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from plumbob.analytic.numerics.rotor.lyapunov import LyapunovExponent, largest_exponent
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion
from plumbob.analytic.systems.pendulums.unending_motion import UnendingMotion
from plumbob.engines.study.results import Study
from plumbob.reports.findings.simple_pendulum.problems import CASES, FORCED, SIMPLE, case, number
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Figure, Finding, Table, row
from plumbob.reports.view.traces import curve, figure, linear, logarithmic, positive

CHAOTIC = f"{SIMPLE}forced-chaotic"
SPAN, LONG = 50.0, 180.0  # [s]
HORIZONS = (1e-12, 1e-9, 1e-6)  # [rad]
AGREED = 3e-12  # [rad] within which two methods must agree over SPAN
FOLLOWED = MappingProxyType(
    {"quick": 300.0, "full": 2000.0}
)  # [s] that the Lyapunov exponent is averaged over


def finding(study: Study) -> Finding:
    """Agreement of two methods on each scene, and the horizon of the chaotic one."""
    every = [name for _, name, _ in CASES if "damped" in name] + list(FORCED)
    chosen = {scene.name for scene in study.scenes} | {CHAOTIC, SIMPLE + "damped-rotating"}
    names = [n for n in every if study.profile == "full" or SIMPLE + n in chosen]
    rows = []
    for name in names:
        motion = _followed(SIMPLE + name, LONG if SIMPLE + name == CHAOTIC else SPAN)
        at, gaps = motion.disagreement
        doubt = motion.uncertainty(at[at <= SPAN])["theta"]
        apart = float(gaps["theta"][at <= SPAN].max())
        rows.append(row(name, number(apart), number(float(doubt.max())),
                        Cell(f"{notation.short(HORIZONS[0])} rad {_until(motion)}")))  # fmt: skip
    motion = _followed(CHAOTIC, LONG)
    exponent = _exponent(study.profile)
    at, gaps = motion.disagreement
    beyond = np.flatnonzero(gaps["theta"] > AGREED)
    parted = float(at[beyond[0]]) if beyond.size else np.inf
    horizons = {tolerance: motion.horizon(tolerance) for tolerance in HORIZONS}
    said = ", ".join(f"{notation.short(x)} rad for {t:.0f} s" for x, t in horizons.items())
    return Finding(
        "references",
        "Damped and forced pendulums have no formula; two methods agree, and chaos has a horizon",
        "measured",
        f"Taylor series and Gauss collocation agree on θ to {AGREED:g} rad for 50 s in every "
        f"scene, and in the chaotic one for {parted:.0f} s. A start and parameters in double "
        f"precision determine its θ to {said}; no method in double precision does better.",
        (
            "Non-linear, damped or forced: no closed form. The reference is a Taylor series of "
            "high order; the second method is Gauss collocation, which shares no formula with it. "
            "The error bar is the larger of their difference and of what one unit in the last "
            "place of every input does to the motion. Undamped motions are Jacobi functions and "
            "linear ones have a closed form.",
            f"In {CHAOTIC} neighbouring motions part as e^(λt), with λ = {exponent.value:.3f} ± "
            f"{exponent.standard_error:.3f}/s (mean over {FOLLOWED[study.profile]:.0f} s after "
            "100 s of transient; one standard error). The scene is run for 50 s. Any comparison "
            "beyond the horizon compares round-off.",
        ),
        (
            Table(
                "How well the reference is known over 50 s",
                ("scene", "two methods differ by [rad]", "error bar [rad]", "known to"),
                tuple(rows),
                "Largest over the run. The error bar may shrink again where neighbours meet.",
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
    return f"for {horizon:.0f} s" if np.isfinite(horizon) else "all along"


def _exponent(profile: str) -> LyapunovExponent:
    problem = case(CHAOTIC).problem
    return largest_exponent(problem.rotor, problem.theta, problem.theta_dot, FOLLOWED[profile])


def _plot(motion: DrivenMotion, exponent: LyapunovExponent) -> Figure:
    at, gaps = motion.disagreement
    times = np.linspace(0.0, LONG, 300)[1:]
    doubt = motion.uncertainty(times)["theta"]
    foot = 1e-15 * np.exp(exponent.value * times)
    return figure(
        "The horizon of the chaotic pendulum",
        "Dotted: what a rounding of each input does. It grows as e^(λt) on the whole, and passes "
        "1e-12 rad at "
        + " and 1e-9 rad at ".join(f"{motion.horizon(x):.0f} s" for x in HORIZONS[:2])
        + ".",
        [
            curve(at[1:], positive(gaps["theta"][1:]), colour="#0072b2", name="two methods apart"),
            curve(times, positive(doubt), colour="#808080", dash="dot", width=2.0,
                  name="error bar"),
            curve(times, foot, colour="#d55e00", dash="dash",
                  name=f"e^(λt), λ = {exponent.value:.3f}/s"),
        ],
        linear("time [s]"),
        logarithmic("|difference of θ| [rad]"),
        legend=True,
        wide=True,
        height=320,
    )  # fmt: skip
