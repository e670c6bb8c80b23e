"""A body that turns about its axle in pymunk: no force acts on its centre, so that no joint is
needed to keep it there.

pymunk moves a body first and then its velocity, so that a torque set before a step is that of the
old angle: Euler's explicit rule, which gains energy. A spring's is evaluated in between, and makes
the step semi-implicit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pymunk

from plumbob.engines.adapters.pymunk.simulation import Translation
from plumbob.engines.trajectory import ByName

Torque = Callable[[float, float], float]


def wheel(
    problem: Any,
    inertia: float,
    limits: ByName,
    *,
    stiffness: float = 0.0,
    torque: Torque | None = None,
    push: Torque | None = None,
) -> Translation:
    """A wheel of this moment of `inertia` [kg m^2] that starts as a `problem` does, on a spring of
    a `stiffness` [N m/rad], or under a `torque` [N m] by its angle and rate, which a spring has in
    its place; and under a `push` [N m] by the time and the rate at which a step begins."""
    space = pymunk.Space()
    body = pymunk.Body(1.0, inertia)
    body.angle = problem.theta
    body.angular_velocity = problem.theta_dot
    spring = pymunk.DampedRotarySpring(body, space.static_body, 0.0, stiffness, 0.0)
    if torque is not None:
        spring.torque_func = lambda spring, angle: -torque(angle, body.angular_velocity)
    space.add(body, spring)

    def act(time: float) -> None:
        assert push is not None
        body.torque = push(time, body.angular_velocity)

    return Translation(
        space,
        lambda: {"theta": body.angle, "theta_dot": body.angular_velocity},
        act if push else None,
        limits,
    )
