"""How long the references are known, and what rounding does next to the top."""

from __future__ import annotations

import math
from types import MappingProxyType

import numpy as np

from plumbob.analytic.numerics.quad import PI, double, quad
from plumbob.analytic.numerics.rotor.lyapunov import largest_exponent
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion
from plumbob.analytic.systems.pendulums.unending_motion import UnendingMotion
from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import case
from plumbob.reports.analyses.saddle_growth import growth_at_saddle
from plumbob.reports.analyses.simple_pendulum.notebook import CASES, FORCED, SIMPLE

CHAOTIC = f"{SIMPLE}forced-chaotic"
SPAN, LONG = 50.0, 180.0  # [s]
HORIZONS = (1e-12, 1e-9, 1e-6)  # [rad]
AGREED = 3e-12  # [rad] within which two methods must agree over SPAN
FOLLOWED = MappingProxyType(
    {"quick": 300.0, "full": 2000.0}
)  # [s] that the Lyapunov exponent is averaged over
EXPONENTS = (1, 2, 3, 4, 5, 6, 8, 10, 12)
TIMES = 101  # over a period


def references(study: Study) -> Record:
    """Agreement of two methods on each scene, and the horizon of the chaotic one."""
    every = [name for name in CASES.values() if "damped" in name] + list(FORCED)
    chosen = {scene.name for scene in study.scenes} | {CHAOTIC, SIMPLE + "damped-rotating"}
    names = [n for n in every if study.profile == "full" or SIMPLE + n in chosen]
    motion, problem = _followed(CHAOTIC, LONG), case(CHAOTIC).problem
    followed = FOLLOWED[study.profile]
    exponent = largest_exponent(problem.rotor, problem.theta, problem.theta_dot, followed)
    at, gaps = motion.disagreement
    beyond = np.flatnonzero(gaps["theta"] > AGREED)
    times = np.linspace(0.0, LONG, 300)[1:]
    return Record(
        scenes=[_certainty(name) for name in names],
        # [s], when two methods differ by more than AGREED in the chaotic scene
        separated=at[beyond[0]] if beyond.size else np.inf,
        horizons=[
            Record(
                tolerance=tolerance,  # [rad]
                time=motion.horizon(tolerance),  # [s]
            )
            for tolerance in HORIZONS
        ],
        exponent=exponent,
        followed=followed,  # [s]
        apart=(at[1:], gaps["theta"][1:]),  # [rad] over time: two methods in the chaotic scene
        error_bar=(times, motion.uncertainty(times)["theta"]),
        growth=(times, 1e-15 * np.exp(exponent.value * times)),  # at the rate of the exponent
        agreed=AGREED,
        tolerance=HORIZONS[0],
        chaotic=CHAOTIC,
    )


def _certainty(name: str) -> Record:
    """How well the reference of a scene is known over SPAN."""
    motion = _followed(SIMPLE + name, LONG if SIMPLE + name == CHAOTIC else SPAN)
    at, gaps = motion.disagreement
    doubt = motion.uncertainty(at[at <= SPAN])["theta"]
    horizon = motion.horizon(HORIZONS[0])
    known = horizon if np.isfinite(horizon) else None
    return Record(
        scene=name,
        apart=gaps["theta"][at <= SPAN].max(),  # [rad], largest difference of two methods
        error_bar=doubt.max(),  # [rad], the largest
        known=known,  # [s], until when to the first of HORIZONS; None for all times
    )


def _followed(name: str, until: float) -> DrivenMotion:
    rotor, problem = case(name).problem.rotor, case(name).problem
    return UnendingMotion(rotor, problem.theta, problem.theta_dot).until(until)


def near_top(study: Study) -> Record:
    """The complement of the angle as the argument, against scipy and against the rounded angle."""
    return Record(starts=[_start(k) for k in EXPONENTS])


def _start(k: int) -> Record:
    """A motion from rest at 10^-k rad from the top over a period: what scipy's formula makes of it,
    and the angle as a double; errors are relative but for those of theta."""
    pendulum: SimplePendulum = case(f"{SIMPLE}near-top-1e-{k}").problem
    rounded, motion = pendulum.started, pendulum.elliptic
    beside = rounded.elliptic
    assert motion
    assert beside
    times = np.linspace(0.0, motion.period, TIMES)
    theta = motion.observe(times)["theta"]
    by_scipy, period = _by_scipy(rounded, times)
    distance = float(double(PI - quad(rounded.theta)))
    return Record(
        k=k,
        period=motion.period,  # [s]
        scipy_period=_or_none(period / motion.period - 1),  # None where it is not a number
        scipy_theta=_or_none(float(np.abs(by_scipy - theta).max())),  # [rad]
        distance=distance / -(pendulum.theta_from_top or math.nan) - 1,
        rounded_period=beside.period / motion.period - 1,
        rounded_theta=np.abs(beside.observe(times)["theta"] - theta).max(),  # [rad]
    )


def _by_scipy(pendulum: SimplePendulum, times: Array) -> tuple[Array, float]:
    """theta [rad] at `times` [s], shape (n,), and the period [s], by the textbook's formula."""
    import scipy.special

    rate = math.sqrt(pendulum.gravity / pendulum.length)
    parameter = math.sin(pendulum.theta / 2) ** 2
    quarter = float(scipy.special.ellipk(parameter))
    with np.errstate(invalid="ignore"):
        sn = scipy.special.ellipj(quarter - rate * times, parameter)[0]
    return 2 * np.arcsin(math.sqrt(parameter) * sn), 4 * quarter / rate


def _or_none(error: float) -> float | None:
    return error if math.isfinite(error) else None


def top_growth(study: Study, scene: Scene) -> Record | None:
    """Growth of the errors at the top, which leaves it at sqrt(g/L)."""
    if "near-top" not in scene.name:
        return None
    problem: SimplePendulum = case(scene.name).problem
    motion = problem.started.elliptic  # the one whose roundings an engine has
    if motion is None:
        return None
    top = Record(theta=math.pi, rate=math.sqrt(problem.gravity / problem.length))
    return growth_at_saddle(study, scene, motion, top)


REFERENCES = Analysis("simple_pendulum/references", references)
NEAR_TOP = Analysis("simple_pendulum/near_top", near_top)
TOP_GROWTH = Analysis("simple_pendulum/top_growth", top_growth)
