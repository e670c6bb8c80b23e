"""Uniform rods in the plane, each pinned to the end of the one before, in pymunk's terms."""

from __future__ import annotations

import cmath
from collections.abc import Iterable

import pymunk

from plumbob.engines.adapters.pymunk.simulation import vector
from plumbob.engines.method import Method

ITERATIONS = 50  # of the solver: a rod's end hears of the first pin after as many as there are rods
Rod = tuple[float, float, float, float]  # mass [kg], length [m], angle from x [rad], rate [rad/s]


def linkage(gravity: float, rods: Iterable[Rod], method: Method) -> pymunk.Space:
    """A space in which `rods` hang on the origin, one on another, under `gravity` [m/s^2]; its
    bodies in this order."""
    space = pymunk.Space()
    space.gravity, space.iterations = (0.0, -gravity), ITERATIONS
    before, pin, end, speed = space.static_body, (0.0, 0.0), 0j, 0j
    for mass, length, angle, rate in rods:
        half, rod = length / 2, pymunk.Body(mass, mass * length**2 / 12)
        arm = half * cmath.exp(1j * angle)
        place, velocity = end + arm, speed + 1j * rate * arm
        rod.angle, rod.angular_velocity = angle, rate
        rod.position, rod.velocity = vector(place), vector(velocity)
        space.add(rod, joined(method, pymunk.PivotJoint(before, rod, pin, (-half, 0.0))))
        before, pin = rod, (half, 0.0)
        end, speed = end + 2 * arm, speed + 2j * rate * arm
    return space


def joined(method: Method, joint: pymunk.Constraint) -> pymunk.Constraint:
    """The joint, closing as the method says."""
    joint.error_bias = float(method.settings.get("error_bias", joint.error_bias))
    return joint
