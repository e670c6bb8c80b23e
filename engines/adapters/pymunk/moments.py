"""Moments on a body that hangs on a turning platform."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from plumbob.engines.adapters.pymunk.links import Link, Links
from plumbob.engines.adapters.pymunk.plane import CLOSE
from plumbob.engines.mechanism import Mechanism, is_constant
from plumbob.engines.method import Unsupported


def turning_rate(mechanism: Mechanism, links: Links) -> float | None:
    """The rate at which the plane turns about its upward direction [rad/s], which a joint
    prescribes; None if no joint does. Raises Unsupported."""
    platforms = [joint for joint in mechanism.joints if joint.velocity is not None]
    if not platforms:
        return None
    platform = platforms[0]
    assert platform.velocity is not None
    alone = len(platforms) == 1 and mechanism.bodies[platform.body].parent == 0
    upright = abs(links.plane.across(links.drawn.axis(platform))) < CLOSE
    if not (alone and upright and is_constant(platform.velocity)):
        raise Unsupported(f"pymunk has no platform that moves as {platform.name} does")
    if np.linalg.norm(np.cross(mechanism.gravity, links.plane.up)) > CLOSE * np.linalg.norm(
        mechanism.gravity
    ):
        raise Unsupported("pymunk has no gravity across the axis of a platform that turns")
    return float(platform.velocity(np.zeros(1))[0])


def platform_spring(
    mechanism: Mechanism, links: Links, link: Link, rate: float
) -> Callable[[object, float], float]:
    """A function that returns the moment of weight and centrifugal forces against the hinge of a
    body [N m], in a plane that turns about its upward direction at a `rate` [rad/s]. Its arguments
    are a spring of pymunk, which is not used, and the body's angle [rad].

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
        """The moment of a body whose product of inertia is zero."""
        sine = math.sin(angle)
        return odd * sine - (spread * sine + even) * math.cos(angle)

    def unevenly(spring: object, angle: float) -> float:
        """The moment of a body with a product of inertia."""
        return against(spring, angle) - product * math.cos(2.0 * angle)

    return unevenly if product else against


def _inertia(
    mechanism: Mechanism, links: Links, link: Link, square: float
) -> tuple[float, float]:
    """The difference of a body's moments of inertia about its hinge, along the plane's right and up
    directions, and the product of inertia [kg m^2], both times `square`, a squared rate."""
    turn = links.drawn.turns[link.body]
    inertia = turn @ mechanism.bodies[link.body].inertia @ turn.T
    right, up = links.plane.right, links.plane.up
    y, z = link.arm.real, link.arm.imag  # [m] place of the centre from the hinge
    difference = float(right @ inertia @ right - up @ inertia @ up)
    spread = difference + link.mass * (z**2 - y**2)
    product = float(right @ inertia @ up) - link.mass * y * z
    return spread * square, product * square
