"""Deviation of the swing on a platform whose drive is not ideal, to first order.

The platform has a finite moment of inertia A, and its drive a torque g A (w0 - w) that brings the
rate w back to w0 at a rate g and holds its mean. With the body's inertia about the vertical axis
J(theta) and the coupling K(theta) = M X S cos theta of the two rotations,

    L = (A + J) w^2 / 2 + K w theta' + I_x theta'^2 / 2 + c cos theta,
    J = J0 + 2 M Y S sin theta + (I_y - I_z) sin^2 theta + I_yz sin 2 theta,

where A -> infinity gives Sudakov 2015, eq. 7. The rate is w0 + u/A and theta leaves the ideal
motion by d/A, to first order in 1/A:

    u'     = -g u - d/dt (J w0 + K theta'),                                u(0) = 0
    I_x d'' = (J'' w0^2/2 - c cos theta) d + J' w0 u - K u',               d(0) = d'(0) = 0

g = 0 is the platform that nothing drives; g -> infinity is the ideal drive. The next order is
smaller by J/A.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum

TOLERANCE = 1e-11  # relative, of the integration
POINTS = 2000  # of a motion, for the largest error


@dataclass(frozen=True)
class PlatformLoad:
    """J(theta) - J0, K(theta) and their slopes [kg m^2]."""

    lever: float  # 2 M Y S
    skew: float  # I_y - I_z
    product: float  # I_yz
    reach: float  # M X S

    @classmethod
    def of(cls, pendulum: Any) -> PlatformLoad:
        """That of a pendulum on a platform."""
        body = pendulum.body
        arm = body.mass * body.com_distance
        skew = body.inertia_y - body.inertia_z
        return cls(2 * arm * pendulum.pivot_y, skew, body.inertia_yz, arm * pendulum.pivot_x)

    def inertia(self, angle: Any) -> Any:
        """J - J0."""
        level = self.lever * np.sin(angle) + self.skew * np.sin(angle) ** 2
        return level + self.product * np.sin(2 * angle)

    def inertia_slope(self, angle: Any) -> Any:
        """J'."""
        level = self.lever * np.cos(angle) + self.skew * np.sin(2 * angle)
        return level + 2 * self.product * np.cos(2 * angle)

    def inertia_bend(self, angle: Any) -> Any:
        """J''."""
        level = -self.lever * np.sin(angle) + 2 * self.skew * np.cos(2 * angle)
        return level - 4 * self.product * np.sin(2 * angle)

    def coupling(self, angle: Any) -> Any:
        """K."""
        return self.reach * np.cos(angle)

    def coupling_slope(self, angle: Any) -> Any:
        """K'."""
        return -self.reach * np.sin(angle)


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


@lru_cache(maxsize=64)  # the same for every method and step of a scene
def platform_error(pendulum: ConePendulum, duration: float, armature: float) -> tuple[float, float]:
    """Largest error of theta [rad] and theta_dot [rad/s] within `duration` [s] that a platform's
    `armature` [kg m^2] brings, which nothing drives."""
    apart = drive_error(pendulum, np.linspace(0.0, duration, POINTS), armature, 0.0)
    return float(np.abs(apart.theta).max()), float(np.abs(apart.theta_dot).max())
