"""Model errors of sequential impulses on a motion in the plane: bounds by reason.

Theory steps the motion as such an engine does (errors.position_first), but for three things. Feet
and body are separate and move straight in a step, not on circles, which gives them a moment of
their own: a turn by an angle a in a step has a relative error of a^2 at most. The iterations leave
a fraction of each change of velocity that the slider or friction asks for at once; the next step
removes it, except while the body slides after one foot has begun to stick or to slip: the other
feet are at their limits, and the residual persists until rest. And a joint that closes its opening
in one step turns the last bit of a position into a velocity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.errors.contact_models.model_error import (
    Bounds,
    ModelError,
    by_observable,
    radius_of_gyration,
    support_arm,
)
from plumbob.analytic.errors.contact_models.sequential_impulse import ROUNDINGS, SequentialImpulse
from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.systems.capsule_setup import CapsuleProblem

SAMPLES = 2001  # of the motion, for its size
AT_SWITCH = 1e-9  # [s]: an event this near to a switch of the slider is caused by it


@dataclass(frozen=True)
class Switches:
    """How often accelerations change at once, the largest that the slider gives the body [m/s^2],
    and how long the body keeps sliding on the residual of such changes, in all [s]."""

    changes: int
    push: float
    sliding: float


@dataclass(frozen=True)
class Extent:
    """How far and how fast a motion goes: way of C [m], turn in both directions [rad], largest
    speed [m/s], rate [rad/s] and distance of the combined centre from C [m]."""

    way: float
    turned: float
    speed: float
    rate: float
    arm: float


@dataclass(frozen=True)
class PlaneError:
    """An error of the heading [rad], of its rate [rad/s], and of C's own position [m] and velocity
    [m/s]."""

    angle: float
    rate: float
    place: float = 0.0
    speed: float = 0.0

    def bounds(self, size: Extent) -> Bounds:
        """The bound of every observable: C turns about the combined centre, and where it goes
        depends on the heading."""
        place = self.angle * (size.arm + size.way) + self.place
        speed = self.rate * size.arm + self.angle * size.speed + self.speed
        return {
            **dict.fromkeys(("heading", "body_angle"), self.angle),
            **dict.fromkeys(("x", "y"), place),
            **dict.fromkeys(("velocity_x", "velocity_y"), speed),
            "heading_rate": self.rate,
        }


def model_error(problem: CapsuleProblem, duration: float, solver: SequentialImpulse) -> ModelError:
    """{observable: {reason: bound}} over `duration` [s]; empty for bare pivots, whose friction is
    not Coulomb's."""
    if solver.model == "pivots":
        return {}
    size, arm, step = _extent(problem, duration), support_arm(problem.setup.capsule), solver.step
    relative = (size.rate * step) ** 2
    bit = ROUNDINGS * ROUNDOFF * (size.way + arm)
    walk = bit * math.sqrt(duration / step)
    errors = {
        "straight steps of feet": PlaneError(relative * size.turned, relative * size.rate),
        "solver iterations": _iterations(problem, solver),
        "rounding of positions": PlaneError(walk / arm, bit / step / arm, walk, bit / step),
    }
    return by_observable({reason: error.bounds(size) for reason, error in errors.items()})


def _iterations(problem: CapsuleProblem, solver: SequentialImpulse) -> PlaneError:
    capsule, switches, step = problem.setup.capsule, _switches(problem), solver.step
    driven = solver.residual * switches.push * step
    stopped = solver.one_foot_residual * (capsule.friction * problem.setup.press * step)
    # A switch inside a step changes the velocity in that step by a part, in the next by the rest.
    speed = 2.0 * (driven + stopped)
    way = switches.changes * speed * step + stopped * switches.sliding
    # Iterations reduce the kinetic energy: a residual rate is a residual speed over the radius of
    # gyration, or over the supports' arm if that is shorter.
    radius = min(support_arm(capsule), radius_of_gyration(capsule))
    return PlaneError(way / radius, speed / radius, way, speed)


def _extent(problem: CapsuleProblem, duration: float) -> Extent:
    """Extent of a motion over `duration` [s]; of a repeated one, of its first turn times their
    number."""
    motion: Any = problem.motion
    count, lasting = motion.count, duration
    if count > 1:
        lasting = motion.period
    times = np.linspace(0.0, lasting, SAMPLES)
    observed = problem.reference.observe(times)
    way = float(np.hypot(np.diff(observed["x"]), np.diff(observed["y"])).sum())
    place = problem.setup.plane_place
    places = np.array([problem.setup.slider]) if place is None else place(times)
    return Extent(
        way=count * way,
        turned=count * float(np.abs(np.diff(observed["heading"])).sum()),
        speed=float(np.hypot(observed["velocity_x"], observed["velocity_y"]).max()),
        rate=float(np.abs(observed["heading_rate"]).max()),
        arm=problem.setup.capsule.mass_ratio * float(np.hypot(*places.T).max()),
    )


def _switches(problem: CapsuleProblem) -> Switches:
    """The demands of the exact motion on the solver."""
    single: Any = problem.motion.single
    times = np.clip(single.path.breakpoints, 0.0, None)
    strongest = float(np.hypot(*single.path.kinematics(times)[2].T).max())
    changes = len(single.events) + times.size
    count = problem.motion.count
    push = single.capsule.mass_ratio * strongest
    return Switches(count * changes, push, count * _sliding(single, times))


def _sliding(single: Any, switches: Any) -> float:
    """Time [s] from each event in which a foot sticks or slips, other than at a switch of the
    slider, to the rest that follows; and the longest slide that a switch starts.

    A push that begins in the last half per cent of a step starts the body with the residual: of a
    plan's some ninety pushes at most one or two do. Such a step demands a push of at most the
    friction, or no foot would stick, and for friction too: the slide counts twice.
    """
    sliding, longest, resting = 0.0, 0.0, single.rest_time
    modes_before = (None, *(event.mode for event in single.events[:-1]))
    for event, before in zip(reversed(single.events), reversed(modes_before), strict=True):
        if event.mode == "rest":
            resting = event.time
        elif event.mode == "pivot" or np.abs(switches - event.time).min() > AT_SWITCH:
            sliding += resting - event.time
        elif before == "rest":
            longest = max(longest, resting - event.time)
    return float(sliding + 2.0 * longest)
