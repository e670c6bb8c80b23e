"""Deviations by inertia: of a pendulum whose bob should be a point, or, to first order, on a
platform whose drive is not ideal.

A bob of moment of inertia I, meant to be a point, is like a mass m l^2 that is larger by I.

The platform has a finite moment of inertia A, and its drive a torque g A (w0 - w) that brings the
rate w back to w0 at a rate g and holds its mean. With the body's inertia about the vertical axis
J(theta) and the coupling K(theta) = M X S cos theta of the two rotations,

    L = (A + J) w^2 / 2 + K w theta' + I_x theta'^2 / 2 + c cos theta,
    J = J0 + 2 M Y S sin theta + (I_y - I_z) sin^2 theta + I_yz sin 2 theta,

where A -> infinity gives Sudakov 2015, eq. 7. The rate is w0 + u/A and theta leaves the ideal
motion by d/A, to first order in 1/A, where

    u'         = -g u - d/dt (J w0 + K theta'),                            u(0) = 0
    I_x theta'' = J' w^2/2 - c sin theta - K u'/A

and an imaginary 1/A makes d the imaginary part of theta (Squire and Trapp 1998, SIAM Review 40,
110). g = 0 is the platform that nothing drives; g -> infinity is the ideal drive. The next order is
smaller by J/A.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum

TOLERANCE = 1e-11  # relative, of the integration
POINTS = 2000  # of a motion, for the largest error
TINY = 1e-30  # [1/(kg m^2)] 1/A, imaginary


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
    body = pendulum.body
    arm = pendulum.body.mass * pendulum.body.com_distance

    def slopes(time: float, state: Any) -> list[Any]:
        theta, rate, u = state
        sine = np.sin(theta)
        cosine = np.cos(theta)
        w = pendulum.platform_rate + 1j * TINY * u
        k = arm * pendulum.pivot_x * cosine
        j_slope = (
            2.0 * cosine * (arm * pendulum.pivot_y + (body.inertia_y - body.inertia_z) * sine)
        )
        j_slope += 2.0 * body.inertia_yz * np.cos(2.0 * theta)
        bend = (j_slope * w**2 / 2 - arm * pendulum.gravity * sine) / body.inertia_x
        turned = arm * pendulum.pivot_x * sine * rate**2 - k * bend
        u_rate = turned - drive_rate * u - j_slope * rate * w
        return [rate, bend - 1j * TINY * k * u_rate / body.inertia_x, u_rate]

    solution = solve_ivp(
        slopes,
        (0.0, float(times[-1])),
        np.array([pendulum.theta, pendulum.theta_dot, 0.0], dtype=complex),
        "DOP853",
        times,
        rtol=TOLERANCE,
        atol=TOLERANCE,
    )
    theta, rate, u = solution.y / inertia
    return PlatformError(theta.imag / TINY, rate.imag / TINY, u.real)


@lru_cache(maxsize=64)  # the same for every method and step of a scene
def platform_error(
    pendulum: ConePendulum, duration: float, armature: float
) -> tuple[float, float]:
    """Largest error of theta [rad] and theta_dot [rad/s] within `duration` [s] that a platform's
    `armature` [kg m^2] brings, which nothing drives."""
    apart = drive_error(pendulum, np.linspace(0.0, duration, POINTS), armature, 0.0)
    return float(np.abs(apart.theta).max()), float(np.abs(apart.theta_dot).max())


@lru_cache(maxsize=64)
def bob_error(problem: Any, duration: float, moment_ratio: float) -> Mapping[str, float]:
    """Bounds on the observables of a SimplePendulum over `duration` [s] whose bob's moment of
    inertia is `moment_ratio` of m l^2: at most the effect of as many units in the last place of
    every parameter as it has."""
    doubts = problem.motion.uncertainty(np.linspace(0.0, duration, POINTS // 10))
    return {
        name: moment_ratio / (2 * ROUNDOFF) * float(doubt.max())
        for name, doubt in doubts.items()
    }
