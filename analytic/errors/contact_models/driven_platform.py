"""Deviation of the swing on a platform whose drive is not ideal, to first order.

The platform has a finite moment of inertia A, and its drive a torque g A (w0 - w) that brings the
rate w back to w0 at a rate g and holds its mean. With J, K and the Lagrangian of `added_inertia`,
the rate is w0 + u/A and theta leaves the ideal motion by d/A:

    u'     = -g u - d/dt (J w0 + K theta'),                                u(0) = 0
    I_x d'' = (J'' w0^2/2 - c cos theta) d + J' w0 u - K u',               d(0) = d'(0) = 0

g = 0 is the platform that nothing drives; g -> infinity is the ideal drive. The next order is
smaller by J/A.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.errors.contact_models.added_inertia import PlatformLoad
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum

TOLERANCE = 1e-11  # relative, of the integration


@dataclass(frozen=True)
class PlatformError:
    """Deviations from the ideal motion at some times, shape (n,) each, to first order in 1/A."""

    theta: Array  # [rad]
    theta_dot: Array  # [rad/s]
    platform_rate: Array  # [rad/s]


def drive_error(
    pendulum: ConePendulum, times: Array, inertia: float, drive_rate: float
) -> PlatformError:
    """Deviations at `times` [s], shape (n,), of a platform with `inertia` A [kg m^2] and a drive of
    rate g [1/s]."""
    from scipy.integrate import solve_ivp

    pendulum = pendulum.started
    load, w = PlatformLoad.of(pendulum), pendulum.platform_rate
    weight = pendulum.body.mass * pendulum.body.com_distance * pendulum.gravity

    def slopes(time: float, state: Array) -> list[float]:
        theta, rate, u, d, d_rate = state
        j_slope, k = load.inertia_slope(theta), load.coupling(theta)
        bend = (j_slope * w**2 / 2 - weight * np.sin(theta)) / pendulum.body.inertia_x
        u_rate = -drive_rate * u - j_slope * rate * w
        u_rate = u_rate - load.coupling_slope(theta) * rate**2 - k * bend
        pull = (load.inertia_bend(theta) * w**2 / 2 - weight * np.cos(theta)) * d
        pull = pull + j_slope * w * u - k * u_rate
        return [rate, bend, u_rate, d_rate, pull / pendulum.body.inertia_x]

    solution = solve_ivp(
        slopes,
        (0.0, float(times[-1])),
        [pendulum.theta, pendulum.theta_dot, 0.0, 0.0, 0.0],
        "DOP853",
        times,
        rtol=TOLERANCE,
        atol=TOLERANCE,
    )
    u, d, d_rate = solution.y[2:]
    return PlatformError(d / inertia, d_rate / inertia, u / inertia)
