"""What a platform of finite inertia does to the swing of the body that it carries.

The platform is free, and only its armature A holds its rate w. With the body's inertia about the
vertical axis J(theta) and the coupling K(theta) = M X S cos theta of the two rotations,

    L = (A + J) w^2 / 2 + K w theta' + I_x theta'^2 / 2 + c cos theta,
    J = J0 + 2 M Y S sin theta + (I_y - I_z) sin^2 theta,

where A -> infinity gives Sudakov 2015, eq. 7. The momentum about the vertical, which is
(A + J) w + K theta', is constant, so to first order in 1/A the rate is w0 + u/A with

    u = -w0 (J - J(0)) - (K theta' - K(0) theta'(0)),

and theta is off by d/A, where d obeys the equation of motion linearised along the swing,

    I_x d'' = (J'' w0^2 / 2 - c cos theta) d + J' w0 u - K u',        d(0) = d'(0) = 0.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from plumbob.analytic.numerics.rotor.taylor_series import integrate
from plumbob.analytic.numerics.rotor.variational import TangentFlow


@lru_cache(maxsize=64)  # every method and step of a scene asks for the same
def swing_error(problem: Any, duration: float, armature: float) -> tuple[float, float]:
    """Largest error of theta [rad] and theta_dot [rad/s] within `duration` [s] that the platform's
    `armature` [kg m^2] brings, to first order in its inverse (module docstring)."""
    body, rate = problem.body, problem.platform_rate
    arm = body.mass * body.com_distance
    skew = body.inertia_y - body.inertia_z
    rotor = problem.motion.rotor
    flow = TangentFlow(rotor, integrate(rotor, problem.theta, problem.theta_dot, duration))
    theta, theta_dot = flow.states
    theta_dot_dot = rotor.acceleration(0.0, theta, theta_dot)

    def inertia(angle: Any) -> Any:
        return 2 * arm * problem.pivot_y * np.sin(angle) + skew * np.sin(angle) ** 2

    def coupling(angle: Any) -> Any:
        return arm * problem.pivot_x * np.cos(angle)

    inertia_slope = 2 * arm * problem.pivot_y * np.cos(theta) + skew * np.sin(2 * theta)
    coupling_slope = -arm * problem.pivot_x * np.sin(theta)
    lag = rate * (inertia(problem.theta) - inertia(theta))
    lag += coupling(problem.theta) * problem.theta_dot - coupling(theta) * theta_dot
    lag_rate = -rate * inertia_slope * theta_dot
    lag_rate -= coupling_slope * theta_dot**2 + coupling(theta) * theta_dot_dot
    push = (inertia_slope * rate * lag - coupling(theta) * lag_rate) / body.inertia_x
    forcing = np.stack([np.zeros_like(push), push], axis=-1)[..., None]
    response = flow.respond(np.zeros((2, 1)), forcing)
    reached = np.concatenate([response.starts, response.end[None]])[:, :, 0]
    worst = np.max(np.abs(reached), axis=0) / armature
    return float(worst[0]), float(worst[1])
