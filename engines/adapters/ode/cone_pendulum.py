"""The cone pendulum as an equation of motion, from its Lagrangian (Sudakov 2015, eq. 7)."""

from __future__ import annotations

import math
from typing import Any

from plumbob.analytic.parameters import finite
from plumbob.engines.adapters.equation import Equation
from plumbob.engines.method import Method
from plumbob.models.largest import largest_pendulum_rates, speed_bound


def build(problem: Any, method: Method) -> Equation:
    """The equation I_x theta'' = a sin 2theta + b cos theta - c sin theta + I_yz w^2 cos 2theta,
    with a = (I_y - I_z) w^2 / 2, b = M Y S w^2 and c = M g S (eq. 7); `problem` is a ConePendulum.
    Raises ParameterError."""
    problem = problem.started
    body = problem.body
    square = problem.platform_rate**2
    arm = body.mass * body.com_distance
    twice_a: float = (body.inertia_y - body.inertia_z) * square / body.inertia_x
    b: float = arm * problem.pivot_y * square / body.inertia_x
    c: float = arm * problem.gravity / body.inertia_x
    sin = math.sin
    cos = math.cos

    product: float = body.inertia_yz * square / body.inertia_x

    def acceleration(time: float, theta: float, theta_dot: float) -> float:
        """theta'' [rad/s^2]."""
        sine = sin(theta)
        cosine = cos(theta)
        pull = (twice_a * sine + b) * cosine - c * sine
        return pull + product * (cosine - sine) * (cosine + sine)

    return Equation(
        acceleration,
        finite("theta", problem.theta),
        finite("theta_dot", problem.theta_dot),
        speed_bound(problem, 0.0),
        damping_rate=0.0,
        limits=largest_pendulum_rates(problem),
    )
