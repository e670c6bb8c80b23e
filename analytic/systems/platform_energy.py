"""Energies of a body on a driven platform (Sudakov 2015, eqs. 2 to 6), and the work of the drive.

The source writes T as three parts: the pivot's translation (3), its coupling with the motion about
the pivot (4), and the rotation about the pivot (5). Its eq. 9 takes T + U for constant, which it is
not. To keep the platform's rate w, the drive gives the body the angular momentum

    L = w J(theta) + theta_dot M X S cos(theta),
    J = M (X^2 + Y^2) + 2 M Y S sin(theta) + I_y sin^2 + 2 I_yz sin cos + I_z cos^2,

and does the work w (L - L(0)). T + U minus that work is constant. T + U - w L is the Jacobi
integral up to a constant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.smooth.smooth_system import TINY
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum


@dataclass(frozen=True)
class Energies:
    """Energies [J] along a motion, shape (n,) each. The potential energy is zero at the height of
    the platform's origin."""

    translation: Array  # eq. 3
    coupling: Array  # eq. 4
    rotation: Array  # eq. 5
    gravity: Array  # U
    angular_momentum: Array  # about the platform's axis [kg m^2/s]
    work: Array  # work of the drive since the first sample

    @property
    def kinetic(self) -> Array:
        """Kinetic energy T of eq. 6."""
        return self.translation + self.coupling + self.rotation

    @property
    def total(self) -> Array:
        """T + U, which eq. 9 takes for constant."""
        return self.kinetic + self.gravity


def energies(pendulum: ConePendulum, theta: Array, theta_dot: Array) -> Energies:
    """Returns the energies at the states `theta` [rad], `theta_dot` [rad/s], shape (n,)."""
    body = pendulum.body
    w = pendulum.platform_rate
    x = pendulum.pivot_x
    y = pendulum.pivot_y
    arm = body.mass * body.com_distance
    sine = np.sin(theta)
    cosine = np.cos(theta)
    about_z = body.inertia_y * sine**2 + body.inertia_z * cosine**2
    about_z = about_z + 2 * body.inertia_yz * sine * cosine
    inertia = body.mass * (x**2 + y**2) + 2 * arm * y * sine + about_z
    momentum = w * inertia + arm * x * theta_dot * cosine
    return Energies(
        translation=np.full_like(sine, body.mass * w**2 * (x**2 + y**2) / 2),
        coupling=arm * w * (y * w * sine + x * theta_dot * cosine),
        rotation=(body.inertia_x * theta_dot**2 + w**2 * about_z) / 2,
        gravity=pendulum.gravity * (body.mass * pendulum.pivot_z - arm * cosine),
        angular_momentum=momentum,
        work=w * (momentum - momentum[0]) if momentum.size else momentum,
    )


def drive_torque(pendulum: ConePendulum, theta: Array, theta_dot: Array) -> Array:
    """Returns the torque [N m] with which the drive keeps the platform's rate, at the states
    `theta` [rad], `theta_dot` [rad/s], shape (n,): the rate of the angular momentum about the
    platform's axis."""
    acceleration = pendulum.motion.rotor.acceleration(0.0, theta + pendulum.tilt, theta_dot)
    # A complex step in time gives the derivative of the angular momentum.
    next_theta = theta + 1j * TINY * theta_dot
    next_theta_dot = theta_dot + 1j * TINY * acceleration
    momentum = energies(pendulum, next_theta, next_theta_dot).angular_momentum
    return np.asarray(momentum.imag / TINY)
