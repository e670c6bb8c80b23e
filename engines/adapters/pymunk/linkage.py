"""Uniform rods in the plane, each pinned to the end of the one before, in pymunk's terms."""

from __future__ import annotations

import cmath
from collections.abc import Iterable

import pymunk

from plumbob.engines.adapters.pymunk.simulation import vector
from plumbob.engines.method import Method

# of the solver: a rod's end hears of the first pin after as many as there are rods
ITERATIONS = 50
# mass [kg], length [m], angle from x [rad], rate [rad/s]
Rod = tuple[float, float, float, float]


def linkage(gravity: float, rods: Iterable[Rod], method: Method) -> pymunk.Space:
    """A space in which `rods` hang on the origin, one on another, under `gravity` [m/s^2]; its
    bodies in this order."""
    space = pymunk.Space()
    space.gravity = (0.0, -gravity)
    space.iterations = ITERATIONS
    before = space.static_body
    pin = (0.0, 0.0)
    end = 0j
    speed = 0j
    for mass, length, angle, rate in rods:
        half = length / 2
        rod = pymunk.Body(mass, mass * length**2 / 12)
        arm = half * cmath.exp(1j * angle)
        place = end + arm
        velocity = speed + 1j * rate * arm
        rod.angle, rod.angular_velocity = angle, rate
        rod.position, rod.velocity = vector(place), vector(velocity)
        space.add(rod, joined(method, pymunk.PivotJoint(before, rod, pin, (-half, 0.0))))
        before = rod
        pin = (half, 0.0)
        end = end + 2 * arm
        speed = speed + 2j * rate * arm
    return space


def joined(method: Method, joint: pymunk.Constraint) -> pymunk.Constraint:
    """The joint, closing as the method says."""
    joint.error_bias = float(method.settings.get("error_bias", joint.error_bias))
    return joint
