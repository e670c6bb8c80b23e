"""Turn manoeuvres of a plan, each computed to rest, and a survey of turns of all sizes.

Formulas 24-32 of Chernousko 2020 apply as epsilon -> 0. A limit on |w| bounds epsilon from below,
so every turn is computed by `three_points.friction` until the residual motion has ended.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre, slow_arc, turn
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, Limits, too_many
from plumbob.analytic.systems.three_points.equations import Complex
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.analytic.systems.three_points.motion import ThreePointMotion

WAITING = 1.1  # times the residual motion, as a margin
SURVEYED = 8  # turns in a survey, and two more for each doubling beyond a full circle
SHORTEST = 1 / 24  # of the longest of them, or of a full circle
DENSE = 480  # sizes of turn in a survey
AGREED = 1e-14  # relative, of the slider's angle in an exact turn

Drive = Callable[[float], float]
"""The slider's angle [rad], positive -> the angular acceleration Z to cover it with [rad/s^2]."""


@dataclass(frozen=True)
class Outcome:
    """A turn manoeuvre computed to rest: heading gained [rad], shift of C in the body axes of its
    start [m], time until the body rests [s]."""

    manoeuvre: Manoeuvre
    heading: float
    shift: complex
    rest_time: float

    @property
    def swing(self) -> float:
        """Angle through which the slider moves [rad]."""
        given = self.manoeuvre.parameters
        return given["angular_acceleration"] * given["half_time"] ** 2

    @property
    def pause(self) -> float:
        """Time to wait for the residual motion to end [s]."""
        return WAITING * max(0.0, self.rest_time - self.manoeuvre.duration)


@dataclass(frozen=True)
class Circle:
    """The part of the circle that turns use, the slider going round in the direction `sense`.

    A turn is of at most `longest` [rad]. With `extent` [rad] they keep to the arc of that length
    from angle `first` [rad] and the slider returns after each one; without, they go on all round,
    and the first begins at one of `starts` [rad], shape (n,).
    """

    sense: float
    longest: float
    first: float
    extent: float | None
    starts: Array

    def gained(self, heading: float) -> float:
        """What of a turn's `heading` [rad] is the way its slider is to turn the body, against its
        own: negative where the body turned the other way."""
        return -self.sense * heading


def quickest_drive(limits: Limits) -> Drive:
    """Z for which the largest |w|, at half time, is at its limit: there the slider's centripetal
    acceleration is a Z times its whole angle."""

    def drive(swing: float) -> float:
        return limits.acceleration / (limits.radius * math.hypot(1.0, swing))

    return drive


def common_drive(capsule: Capsule, limits: Limits) -> Drive:
    """Z at three times the bound on friction's moment, mu_1 Z = 3 R_0 (Chernousko 2020, eq. 28), as
    far as the limit on |w| allows."""
    scale = TurnManoeuvre(capsule, limits.radius, 1.0, 1e-9)
    common = 3.0 * scale.friction_bound / scale.inertia_ratio
    quickest = quickest_drive(limits)

    def drive(swing: float) -> float:
        return min(common, quickest(swing))

    return drive


@lru_cache(maxsize=1024)
def outcome(
    capsule: Capsule, radius: float, start: float, swing: float, angular_acceleration: float
) -> Outcome:
    """Compute a turn from rest: slider from angle `start` through `swing` [rad], of either sign, at
    +-`angular_acceleration` [rad/s^2] (positive) in each half."""
    return _followed(capsule, radius, start, swing, angular_acceleration, None)[0]


def _followed(
    capsule: Capsule,
    radius: float,
    start: float,
    swing: float,
    angular_acceleration: float,
    near: ThreePointMotion | None,
) -> tuple[Outcome, ThreePointMotion]:
    """As `outcome`, at less cost from a motion that is nearly the same, and the motion."""
    half_time = math.sqrt(abs(swing) / angular_acceleration)
    drive = math.copysign(angular_acceleration, swing)
    made = turn(radius, start, drive, half_time)
    motion = three_point_motion(capsule, made.path)
    motion = motion if near is None else motion.beside(near)
    end = motion.at(np.array([motion.rest_time]))
    found = Outcome(made, float(end.heading[0]), complex(*end.position[0]), motion.rest_time)
    return found, motion


@dataclass(frozen=True)
class Survey:
    """Results of turns of one sense, shape (n,) each, against the slider's angle `swings` [rad]
    from 0 up: size of the heading gained [rad], rising; shift of C [m] for a slider that starts on
    the body's x axis; time with the residual motion, and for a return of that angle [s]."""

    swings: Array
    headings: Array
    shifts: Complex
    times: Array
    returns: Array

    def swing(self, heading: float) -> float:
        """The slider's angle [rad] for the `heading` [rad], interpolated."""
        return float(np.interp(heading, self.headings, self.swings))

    def fewest(self, wanted: float) -> int:
        """Least number of turns for a heading `wanted` [rad]."""
        return math.ceil(wanted / float(self.headings[-1]) * (1.0 - 1e-9))


def survey(capsule: Capsule, limits: Limits, circle: Circle, drive: Drive) -> Survey:
    """Compute a few turns between a small one and the longest, and interpolate. Raises
    ParameterError, naming the acceleration, if none turns the body the way it should."""
    doublings = max(0, math.ceil(math.log2(circle.longest / FULL_CIRCLE)))
    least = SHORTEST * min(circle.longest, FULL_CIRCLE)
    if not least > 0.0:
        raise ParameterError("stroke", limits.stroke, "large enough for a turn")
    swings = np.geomspace(least, circle.longest, SURVEYED + 2 * doublings)
    found = [
        outcome(capsule, limits.radius, circle.first, circle.sense * s, drive(s))
        for s in map(float, swings)
    ]
    dense = circle.longest * np.arange(DENSE + 1) / DENSE

    def interpolated(values: list[float], power: float) -> Array:
        from scipy.interpolate import PchipInterpolator

        # Divided by this power of the angle they have a limit at 0 and hardly change.
        curve = PchipInterpolator(swings, values / swings**power)
        return np.asarray(curve(np.maximum(dense, swings[0])) * dense**power)

    headings = interpolated([circle.gained(f.heading) for f in found], 1.0)
    count = int(np.argmax(headings)) + 1
    if count == 1 or np.any(np.diff(headings[:count]) <= 0.0):
        need = f"large enough to turn the body with a slider {limits.radius:g} m from C"
        raise ParameterError("acceleration", limits.acceleration, need)
    unturned = [f.shift * np.exp(-1j * circle.first) for f in found]
    across, along = ([part(s) for s in unturned] for part in (np.real, np.imag))
    return Survey(
        swings=dense[:count],
        headings=headings[:count],
        shifts=(interpolated(across, 1.0) + 1j * interpolated(along, 1.0))[:count],
        times=interpolated([f.manoeuvre.duration + f.pause for f in found], 0.5)[:count],
        returns=interpolated(_returns(capsule, limits, circle, found), 0.5)[:count],
    )


def _returns(capsule: Capsule, limits: Limits, circle: Circle, found: list[Outcome]) -> list[float]:
    """Time of the slow return after each turn [s]; 0 where the slider continues all round."""
    if circle.extent is None:
        return [0.0] * len(found)
    ends = [(circle.first + turned.swing, circle.first) for turned in found]
    return [slow_arc(capsule, limits.radius, *e, limits.holding).duration for e in ends]


def exact_turn(
    capsule: Capsule,
    limits: Limits,
    circle: Circle,
    drive: Drive,
    start: float,
    longest: float,
    guess: float,
    wanted: float,
) -> Outcome | None:
    """The turn from angle `start` that gives the heading `wanted` [rad] (its size), the slider's
    angle being near `guess` [rad]; None if it takes more than `longest` [rad]."""
    from scipy.optimize import brentq

    near: ThreePointMotion | None = None

    @cache
    def followed(swing: float) -> Outcome:
        nonlocal near
        given = (limits.radius, start, circle.sense * swing, drive(swing))
        found, near = _followed(capsule, *given, near)
        return found

    def excess(swing: float) -> float:
        return circle.gained(followed(swing).heading) - wanted

    low, high = 0.98 * min(guess, longest), min(1.02 * guess, longest)
    while excess(low) > 0.0:
        low, high = 0.9 * low, low
    while excess(high) < 0.0:
        if high >= longest:
            return None
        low, high = high, min(1.1 * high, longest)
    root = brentq(excess, low, high, xtol=AGREED * guess, rtol=4 * np.finfo(float).eps)
    return followed(float(root))


def equal_turns(
    capsule: Capsule, limits: Limits, circle: Circle, wanted: float, drive: Drive
) -> tuple[Outcome, ...]:
    """As few equal turn manoeuvres as possible for the heading `wanted` [rad], each from the same
    place. Raises ParameterError."""
    seen = survey(capsule, limits, circle, drive)
    count, found = seen.fewest(abs(wanted)), None
    while found is None:
        if count > limits.manoeuvres:
            raise too_many(limits, count)
        each = abs(wanted) / count
        found = exact_turn(
            *(capsule, limits, circle, drive, circle.first, circle.longest),
            *(seen.swing(each), each),
        )
        count += found is None
    return (found,) * count
