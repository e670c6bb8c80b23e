"""Errors by added inertia: of a pendulum's bob, and of a platform whose drive is not ideal.

Bob: an engine models a point mass as a small body with a moment of inertia I. The pendulum's moment
of inertia m l^2 is then larger by I.

Platform: it has a finite moment of inertia A. Its drive has the torque g A (w0 - w), which returns
the rate w to w0 at the rate g. The body has the inertia J(theta) about the vertical axis, and
K(theta) = M X S cos theta couples the two rotations. The Lagrangian is

    L = (A + J) w^2 / 2 + K w theta' + I_x theta'^2 / 2 + c cos theta,
    J = J0 + 2 M Y S sin theta + (I_y - I_z) sin^2 theta + I_yz sin 2 theta,

In the limit A -> infinity, this is Sudakov 2015, eq. 7. To first order in 1/A the platform's rate
is w0 + u/A and theta deviates from the ideal motion by d/A, where

    u'         = -g u - d/dt (J w0 + K theta'),                            u(0) = 0
    I_x theta'' = J' w^2/2 - c sin theta - K u'/A

With an imaginary 1/A, d is the imaginary part of theta (Squire and Trapp 1998, SIAM Review 40,
110). A platform without a drive has g = 0; the ideal drive is the limit g -> infinity. The next
order is smaller by J/A.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum

INTEGRATION_TOLERANCE = 1e-11  # relative tolerance of the integration
ERROR_SAMPLES = 2000  # samples of a motion among which the largest error is sought
IMAGINARY_INVERSE_INERTIA = 1e-30  # [1/(kg m^2)] imaginary 1/A


@dataclass(frozen=True)
class PlatformError:
    """Deviations from the motion with an ideal drive, to first order in 1/A; shape (n,) each."""

    theta: Array  # [rad]
    theta_dot: Array  # [rad/s]
    platform_rate: Array  # [rad/s]


def drive_error(
    pendulum: ConePendulum, times: Array, inertia: float, drive_rate: float
) -> PlatformError:
    """Returns the deviations from the ideal motion at `times` [s], shape (n,).

    The platform has the moment of `inertia` A [kg m^2] and a drive of the rate g = `drive_rate`
    [1/s].
    """
    from scipy.integrate import solve_ivp

    pendulum = pendulum.started
    solution = solve_ivp(
        _equations(pendulum, drive_rate),
        (0.0, float(times[-1])),
        np.array([pendulum.theta, pendulum.theta_dot, 0.0], dtype=complex),
        "DOP853",
        times,
        rtol=INTEGRATION_TOLERANCE,
        atol=INTEGRATION_TOLERANCE,
    )
    theta, theta_dot, u = solution.y / inertia
    return PlatformError(
        theta=theta.imag / IMAGINARY_INVERSE_INERTIA,
        theta_dot=theta_dot.imag / IMAGINARY_INVERSE_INERTIA,
        platform_rate=u.real,
    )


def _equations(
    pendulum: ConePendulum, drive_rate: float
) -> Callable[[float, Any], Sequence[Any]]:
    """Returns the function from time and (theta, theta', u) to the rates of these three (module
    docstring). 1/A is imaginary, of the size IMAGINARY_INVERSE_INERTIA."""
    body = pendulum.body
    moment = body.mass * body.com_distance

    def slopes(time: float, state: Any) -> Sequence[Any]:
        """Returns theta', theta'' and u'. Here `coupling` is K and `inertia_slope` is dJ/dtheta."""
        theta, theta_dot, u = state
        sine = np.sin(theta)
        cosine = np.cos(theta)
        platform_rate = pendulum.platform_rate + 1j * IMAGINARY_INVERSE_INERTIA * u
        coupling = moment * pendulum.pivot_x * cosine
        inertia_slope = moment * pendulum.pivot_y + (body.inertia_y - body.inertia_z) * sine
        inertia_slope *= 2.0 * cosine
        inertia_slope += 2.0 * body.inertia_yz * np.cos(2.0 * theta)
        weight = moment * pendulum.gravity * sine
        ideal_acceleration = (inertia_slope * platform_rate**2 / 2 - weight) / body.inertia_x
        reaction = (
            moment * pendulum.pivot_x * sine * theta_dot**2 - coupling * ideal_acceleration
        )
        u_rate = reaction - drive_rate * u - inertia_slope * theta_dot * platform_rate
        deviation = 1j * IMAGINARY_INVERSE_INERTIA * coupling * u_rate / body.inertia_x
        return [theta_dot, ideal_acceleration - deviation, u_rate]

    return slopes


@lru_cache(maxsize=64)  # all methods and steps of a scene share the result
def platform_error(
    pendulum: ConePendulum, duration: float, armature: float
) -> tuple[float, float]:
    """Returns the largest errors of theta [rad] and theta_dot [rad/s] within `duration` [s].

    They are the errors of a platform without a drive. Its moment of inertia is `armature` [kg m^2];
    that of the ideal platform is infinite.
    """
    error = drive_error(pendulum, np.linspace(0.0, duration, ERROR_SAMPLES), armature, 0.0)
    return float(np.abs(error.theta).max()), float(np.abs(error.theta_dot).max())


@lru_cache(maxsize=64)
def bob_error(problem: Any, duration: float, moment_ratio: float) -> Mapping[str, float]:
    """Returns bounds on the errors of a SimplePendulum whose bob is no point: {observable: bound}.

    The bob's moment of inertia about its centre is `moment_ratio` times m l^2. Its effect over
    `duration` [s] is at most the effect of a relative change of every parameter by `moment_ratio`.
    The uncertainty is the effect of rounding every parameter: it is scaled up to that change.
    """
    doubts = problem.motion.uncertainty(np.linspace(0.0, duration, ERROR_SAMPLES // 10))
    roundings = moment_ratio / (2 * ROUNDOFF)
    return {name: roundings * float(doubt.max()) for name, doubt in doubts.items()}
