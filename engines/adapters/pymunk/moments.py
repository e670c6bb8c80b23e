"""Moments and forces of joints: springs, dampers, actuators, and a platform that turns."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from plumbob.engines.adapters.pymunk.links import Link, Links
from plumbob.engines.adapters.pymunk.plane import CLOSE
from plumbob.engines.mechanism import Actuator, Joint, Mechanism
from plumbob.engines.method import Unsupported

Effort = Callable[[float, float, Sequence[float]], float]
"""The force of a joint's actuators and of its spring and damper [N] or [N m] by its coordinate,
its velocity and the controls."""
# Times [s] at which a platform is asked whether it keeps its rate.
TIMES = np.concatenate([[0.0], 2.0 ** np.arange(-10.0, 11.0)])


def effort(joint: Joint, actuators: Sequence[Actuator]) -> Effort:
    """The force of these actuators and of a joint's spring and damper."""
    damping = float(joint.damping[0])
    stiffness = joint.stiffness
    rest = float(joint.rest[0])
    forces = list(map(_force, actuators))
    if not (forces or stiffness):
        return lambda q, rate, controls: -damping * rate
    if not forces:
        return lambda q, rate, controls: -stiffness * (q - rest) - damping * rate
    if len(forces) == 1 and not (stiffness or damping):
        return forces[0]

    def force(q: float, rate: float, controls: Sequence[float]) -> float:
        total = -stiffness * (q - rest) - damping * rate
        for of_actuator in forces:
            total += of_actuator(q, rate, controls)
        return total

    return force


def _force(actuator: Actuator) -> Effort:
    """The force of an actuator on its joint."""
    gear = actuator.gear
    gain = actuator.gain
    control = actuator.control
    constant, by_place, by_rate = actuator.bias
    low, high = actuator.force_range or (-math.inf, math.inf)
    least, most = actuator.control_range or (-math.inf, math.inf)
    by_place, by_rate = gear * by_place, gear * by_rate

    def force(q: float, rate: float, controls: Sequence[float]) -> float:
        bent = constant + by_place * q + by_rate * rate
        return gear * min(
            max(gain * min(max(controls[control], least), most) + bent, low), high
        )

    return force


def turning_rate(mechanism: Mechanism, links: Links) -> float | None:
    """The rate [rad/s] at which the plane turns about its upward direction: that of the joint whose
    motion is prescribed, None without one. Raises Unsupported."""
    platforms = [joint for joint in mechanism.joints if joint.velocity is not None]
    if not platforms:
        return None
    platform = platforms[0]
    assert platform.velocity is not None
    rates = platform.velocity(TIMES)
    alone = len(platforms) == 1 and mechanism.bodies[platform.body].parent == 0
    upright = abs(links.plane.across(links.drawn.axis(platform))) < CLOSE
    if not (alone and upright and np.all(rates == rates[0])):
        raise Unsupported(f"pymunk has no platform that moves as {platform.name} does")
    if np.linalg.norm(np.cross(mechanism.gravity, links.plane.up)) > CLOSE * np.linalg.norm(
        mechanism.gravity
    ):
        raise Unsupported("pymunk has no gravity across the axis of a platform that turns")
    return float(rates[0])


def platform_spring(
    mechanism: Mechanism, links: Links, link: Link, rate: float
) -> Callable[[object, float], float]:
    """The moment of the weight and of the centrifugal forces against the hinge of a body [N m], by
    a spring of pymunk, which has no effect, and the body's angle, in a plane that turns about its
    upward direction at a rate [rad/s].

    The centrifugal moment of a body whose centre is (y, z) from a hinge at p from the axis is
    (I_yz - m z (p + y)) rate^2, and the turned I_yz is I_yz cos 2a + (I_yy - I_zz) sin 2a / 2 with
    moments of inertia about the centre. Coriolis forces are across the plane.
    """
    assert link.hinge is not None
    platform = next(joint for joint in mechanism.joints if joint.velocity is not None)
    axis = links.plane.flat(links.drawn.point(platform.body, platform.place))
    arm = link.arm
    weight = link.mass * float(links.plane.up @ mechanism.gravity)
    lever = link.mass * (link.hinge.place - axis).real * rate**2
    even = weight * arm.real - lever * arm.imag
    odd = weight * arm.imag + lever * arm.real
    spread, product = _inertia(mechanism, links, link, rate**2)

    def against(spring: object, angle: float) -> float:
        sine = math.sin(angle)
        return odd * sine - (spread * sine + even) * math.cos(angle)

    def unevenly(spring: object, angle: float) -> float:
        return against(spring, angle) - product * math.cos(2.0 * angle)

    return unevenly if product else against


def _inertia(
    mechanism: Mechanism, links: Links, link: Link, square: float
) -> tuple[float, float]:
    """The difference of a body's moments of inertia about a hinge, along the plane's directions to
    the right and up, and their product of inertia [kg m^2], times a `square` of a rate."""
    turn = links.drawn.turns[link.body]
    inertia = turn @ mechanism.bodies[link.body].inertia @ turn.T
    right, up = links.plane.right, links.plane.up
    y, z = link.arm.real, link.arm.imag
    difference = float(right @ inertia @ right - up @ inertia @ up)
    spread = difference + link.mass * (z**2 - y**2)
    product = float(right @ inertia @ up) - link.mass * y * z
    return spread * square, product * square
