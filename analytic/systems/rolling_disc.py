"""A thin disc that rolls on a plane without slipping, in Euler's angles.

The angles are the precession f about the vertical, the tilt t of the axis from the vertical, and
the spin s about the axis; w = s' + f' cos t. With h = 1 if the contact holds the disc, 0 if it is
free, in units of m R^2 (Routh 1905, Dynamics of a System of Rigid Bodies, Advanced Part, 244;
O'Reilly 1996, Nonlinear Dyn. 10, 287), T = (1/4 + h) t'^2/2 + f'^2 sin^2 t/8 + (1/2 + h) w^2/2, V =
h (g/R) sin t, and

    t'' (1/4 + h) = f'^2 sin t cos t/4 - (1/2 + h) f' w sin t - h (g/R) cos t
    w' (1/2 + h) = h f' t' sin t,   f'' sin t/4 = w t'/2 - f' t' cos t/2                        (1)

These are not Lagrange's equations, because the constraint is not a function of the angles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import cos, sin
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.parameters import ParameterError, check_fields
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.heavy_top import TOP_ANGLES, TOP_RATES, euler_masses


@dataclass(frozen=True)
class RollingDisc:
    """A disc of `radius` [m] under `gravity` [m/s^2], with the `tilt` [rad] of its axis, which is
    pi/2 for an upright disc, and rates [rad/s] at time 0. Raises ParameterError.

    >>> round(RollingDisc(0.1, 9.81, 1.2, 4.0, 0.0, 1.0).steady_spin, 6)
    -7.564405
    """

    radius: float
    gravity: float
    tilt: float
    precession_rate: float
    tilt_rate: float
    spin_rate: float

    def __post_init__(self) -> None:
        check_fields(self, ("radius",), ("gravity",))
        if not 0.0 < self.tilt < np.pi:
            raise ParameterError(
                "tilt", self.tilt, "between 0 and pi, where the disc lies flat"
            )

    @cached_property
    def motion(self) -> CertifiedMotion:
        """The exact motion."""
        start = (0.0, self.tilt, 0.0)
        rates = tuple(getattr(self, name) for name in TOP_RATES)
        sizes = {"radius": self.radius, "gravity": self.gravity}
        return CertifiedMotion(
            SmoothSystem(
                coordinates=TOP_ANGLES,
                rates=TOP_RATES,
                mass_matrix=lambda p, q: masses(1.0, q),
                forces=lambda p, time, q, v: moments(1.0, p.gravity / p.radius, q, v),
                parameters=sizes,
                position=start,
                rate=rates,
            )
        )

    def potential(self, observed: Signals) -> Array:
        """Returns the potential energy divided by the mass and the squared radius [1/s^2]."""
        return np.asarray(self.gravity / self.radius * sin(observed["tilt"]))

    @property
    def steady_spin(self) -> float:
        """The spin rate [rad/s] at which the disc keeps its initial tilt and precession."""
        precession = self.precession_rate
        sine = math.sin(self.tilt)
        cosine = math.cos(self.tilt)
        pull = self.gravity / (self.radius * precession * sine)
        total_spin = cosine * (precession / 4 - pull) / 1.5  # w of the module's docstring
        return total_spin - precession * cosine

    @property
    def wobble(self) -> float:
        """Squared frequency [rad^2/s^2] of small deviations from rolling upright with the initial
        spin; negative if they grow."""
        return 2.4 * self.spin_rate**2 - 0.8 * self.gravity / self.radius


def masses(held: float, q: Any) -> tuple[tuple[Any, ...], ...]:
    """Returns the mass matrix of T, in units of m R^2, at the angles `q` [rad]. `held` is h."""
    return euler_masses(q, 0.25, 0.25 + held, 0.5 + held)


def moments(held: float, pull: Any, q: Any, v: Any) -> tuple[Any, Any, Any]:
    """Returns the right-hand side of eq. 1 for that matrix; `held` is h, `pull` is g/R [1/s^2]."""
    sine = sin(q[1])
    cosine = cos(q[1])
    w = v[2] + v[0] * cos(q[1])
    return (
        sine * v[1] * (w / 2 + 2 * held * v[0] * cosine),
        sine * v[0] * (v[0] * cosine / 4 - (0.5 + held) * w) - held * pull * cosine,
        (0.5 + 2 * held) * v[0] * v[1] * sine,
    )
