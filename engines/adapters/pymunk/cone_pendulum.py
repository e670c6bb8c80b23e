"""The cone pendulum in pymunk: a body about its axle under a torque that depends on its angle.

pymunk is an engine of the plane and has no rotating platform: the centrifugal moments about the
axle, and the weight's, are applied as a torque. The torque has to be that of the angle at which
the velocity is integrated. pymunk moves a body first and then its velocity, so that a torque set
before the step is that of the old angle: Euler's explicit rule, which gains energy. A velocity
function is called in between, and makes the step semi-implicit.
"""

from __future__ import annotations

import math
from typing import Any

import pymunk

from plumbob.engines.adapters.divergence import limits_on_platform
from plumbob.engines.adapters.pymunk.simulation import Translation
from plumbob.engines.method import Method
from plumbob.engines.trajectory import ByName


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a ConePendulum."""
    problem = problem.started
    body, square = problem.body, problem.platform_rate**2
    arm = body.mass * body.com_distance
    spread: float = (body.inertia_y - body.inertia_z) * square
    product: float = body.inertia_yz * square
    lever: float = arm * problem.pivot_y * square
    weight: float = arm * problem.gravity

    def torque(theta: float) -> float:
        """Of the Lagrangian (Sudakov 2015, eq. 7), with a product of inertia [N m]."""
        sine, cosine = math.sin(theta), math.cos(theta)
        return (spread * sine + lever) * cosine - weight * sine + product * math.cos(2 * theta)

    space = pymunk.Space()
    wheel = pymunk.Body(body.mass, body.inertia_x)  # its centre on the axle: no joint is needed
    wheel.angle, wheel.angular_velocity = problem.theta, problem.theta_dot
    space.add(wheel)

    def turn(turned: pymunk.Body, gravity: Any, damping: float, dt: float) -> None:
        turned.torque = torque(turned.angle)
        pymunk.Body.update_velocity(turned, gravity, damping, dt)

    wheel.velocity_func = turn

    def read() -> ByName:
        return {"theta": wheel.angle, "theta_dot": wheel.angular_velocity}

    return Translation(space, read, limits=limits_on_platform(problem))
