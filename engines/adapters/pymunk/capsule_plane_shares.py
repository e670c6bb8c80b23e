"""What feet in pymunk add to a motion in the plane, apart from the step: bounds by reason.

Theory steps the motion as pymunk does (errors.position_first), but for three things. Feet
and body stand apart and go along chords of their circles, which gives them a moment of their own:
of what turns through an angle a in a step, a share of a^2 at most. Sweeps leave a share of each
change of velocity that the slider or friction asks for at once; the next step takes it, but not
from a body that slides as one foot comes to grip or gives way: the others give all they can, and
what is left stays until it rests. And a joint that closes what is open in one
step makes a velocity of the last bit of a place.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.systems.capsule import ROUNDOFF
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.engines.adapters.pymunk.capsule_feet import few_feet_left_by_sweep

ROUNDINGS = 8  # on the way from places to a velocity
LOOKED_AT = 2001  # times of the motion, to know its size
PLACES, SPEEDS = ("x", "y"), ("velocity_x", "velocity_y")
ANGLES, RATES = ("heading", "body_angle"), ("heading_rate",)
ON_TIME = 1e-9  # [s]: an event this near to a switch is its doing
Shares = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class Demand:
    """How often accelerations change at once, the largest that the slider gives the body [m/s^2],
    and how long the body moves on [s] after each change in which a foot grips or gives way."""

    changes: int
    push: float
    yielding: float


@dataclass(frozen=True)
class Extent:
    """How far and how fast a motion goes: way of C [m], turn to and fro [rad], largest speed [m/s],
    rate [rad/s] and distance of the combined centre from C [m]."""

    way: float
    turned: float
    speed: float
    rate: float
    arm: float


def extent(problem: CapsuleProblem, duration: float) -> Extent:
    """Extent of a motion over `duration` [s]; of a train, of its first turn times their number."""
    count, lasting = getattr(problem.motion, "count", 1), duration
    if count > 1:
        lasting = problem.motion.period
    times = np.linspace(0.0, lasting, LOOKED_AT)
    seen = problem.reference.observe(times)
    way = float(np.hypot(np.diff(seen["x"]), np.diff(seen["y"])).sum())
    place = problem.setup.plane_place
    places = np.array([problem.setup.slider]) if place is None else place(times)
    return Extent(
        way=count * way,
        turned=count * float(np.abs(np.diff(seen["heading"])).sum()),
        speed=float(np.hypot(seen["velocity_x"], seen["velocity_y"]).max()),
        rate=float(np.abs(seen["heading_rate"]).max()),
        arm=problem.setup.capsule.mass_ratio * float(np.hypot(*places.T).max()),
    )


def plane_shares(
    problem: CapsuleProblem, duration: float, slowest: float, count: int, step: float
) -> Shares:
    """{observable: {reason: bound}} over `duration` [s] with `count` sweeps in a step of `step`
    [s], `slowest` what one leaves of a velocity while every foot grips."""
    size, found = extent(problem, duration), dict[str, dict[str, float]]()
    capsule = problem.setup.capsule
    arm = math.sqrt(float(np.square(capsule.supports).sum()) / 3)
    apart = (size.rate * step) ** 2
    _add(found, "feet behind the turn", size, apart * size.turned, apart * size.rate)
    asked = demand(problem)
    driven = slowest**count * asked.push * step
    stopped = max(few_feet_left_by_sweep(capsule, 1), slowest) ** count
    stopped *= capsule.friction * problem.setup.press * step
    speed = 2.0 * (
        driven + stopped
    )  # a switch inside a step asks for a part, the next for the rest
    way = asked.changes * speed * step + stopped * asked.yielding
    # Sweeps take from the kinetic energy: a rate left is a speed left over the radius of gyration.
    about = min(arm, math.sqrt(capsule.inertia / capsule.body_mass))
    _add(found, "sweeps", size, way / about, speed / about, way, speed)
    bit = ROUNDINGS * ROUNDOFF * (size.way + arm)
    lost = bit * math.sqrt(duration / step)
    _add(found, "rounding of places", size, lost / arm, bit / step / arm, lost, bit / step)
    return found


def demand(problem: CapsuleProblem) -> Demand:
    """What the exact motion asks of the sweeps."""
    motion: Any = problem.reference
    motion = motion.motion
    count, motion = getattr(motion, "count", 1), motion.single
    path = motion.path
    switches = np.clip(path.breakpoints, 0.0, None)
    strongest = float(np.hypot(*path.kinematics(switches)[2].T).max())
    yielding, resting = 0.0, motion.rest_time
    before = (None, *(event.mode for event in motion.events[:-1]))
    longest = 0.0  # of the slides that a switch sets off
    for event, last in zip(reversed(motion.events), reversed(before), strict=True):
        if event.mode == "rest":
            resting = event.time
        elif event.mode == "pivot" or np.abs(switches - event.time).min() > ON_TIME:
            yielding += resting - event.time
        elif last == "rest":
            longest = max(longest, resting - event.time)
    # A push that begins in the last half per cent of a step sets the body off by what sweeps leave:
    # of a plan's some ninety pushes at most one or two do.
    yielding += longest
    changes = len(motion.events) + switches.size
    return Demand(count * changes, motion.capsule.mass_ratio * strongest, count * yielding)


def _add(
    found: dict[str, dict[str, float]],
    reason: str,
    size: Extent,
    turned: float,
    rate: float,
    slid: float = 0.0,
    slipping: float = 0.0,
) -> None:
    """An angle [rad] and a rate [rad/s] that are off, and C by `slid` [m] and `slipping` [m/s] of
    its own, in every observable: C goes round the combined centre, and where to depends on the
    heading."""
    place = turned * (size.arm + size.way) + slid
    speed = rate * size.arm + turned * size.speed + slipping
    for names, bound in ((ANGLES, turned), (PLACES, place), (SPEEDS, speed), (RATES, rate)):
        for name in names:
            found.setdefault(name, {})[reason] = bound
