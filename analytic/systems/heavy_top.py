"""Lagrange's top: a symmetric body under gravity that turns about a fixed point of its axis.

Euler's angles are the precession f about the vertical, the tilt t from the vertical, and the spin s
about the body's axis. The moments of inertia about the fixed point are A = A_centre + m l^2 across
the axis and C about it (Landau and Lifshitz 1976, Mechanics, 35, problem 1):

    T = A (t'^2 + f'^2 sin^2 t)/2 + C (s' + f' cos t)^2/2,   V = m g l cos t                    (1)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import cos, sin
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.parameters import ParameterError, check_fields
from plumbob.analytic.reference import Signals

TOP_ANGLES = ("precession", "tilt", "spin")
TOP_RATES = tuple(f"{name}_rate" for name in TOP_ANGLES)
TOP_CONSTANTS = ("mass", "length", "inertia_across", "inertia_axis", "gravity")


@dataclass(frozen=True)
class HeavyTop:
    """A top of `mass` [kg] with its centre of mass at `length` [m] from the fixed point, moments of
    inertia about its centre of mass [kg m^2], and the `tilt` [rad] and the rates [rad/s] at time 0.
    Raises ParameterError.

    >>> top = HeavyTop(1.0, 0.1, 2e-3, 1e-3, 9.81, 0.5, 0.0, 1.0, 200.0)
    >>> round(float(top.motion.observe(np.array([1.0]))["precession"][0]), 6)
    6.167962
    """

    mass: float
    length: float
    inertia_across: float
    inertia_axis: float
    gravity: float
    tilt: float
    precession_rate: float
    tilt_rate: float
    spin_rate: float

    def __post_init__(self) -> None:
        check_fields(self, TOP_CONSTANTS[:-1], TOP_CONSTANTS[-1:])
        if self.inertia_axis > 2 * self.inertia_across:
            need = f"at most twice the moment across, {2 * self.inertia_across:g} kg m^2"
            raise ParameterError("inertia_axis", self.inertia_axis, need)
        if not 0.0 < self.tilt < np.pi:
            raise ParameterError(
                "tilt", self.tilt, "between 0 and pi, where the axis is vertical"
            )

    @cached_property
    def motion(self) -> CertifiedMotion:
        """The exact motion."""
        parameters = {name: getattr(self, name) for name in TOP_CONSTANTS}
        rates = self.precession_rate, self.tilt_rate, self.spin_rate
        start = (0.0, self.tilt, 0.0)
        return CertifiedMotion(
            SmoothSystem(
                coordinates=TOP_ANGLES,
                rates=TOP_RATES,
                mass_matrix=_masses,
                forces=_moments,
                parameters=parameters,
                position=start,
                rate=rates,
            )
        )

    def conserved(self, observed: Signals) -> Signals:
        """Returns the conserved quantities: the energy [J], and the angular momenta about the
        vertical and about the axis [kg m^2/s]."""
        kinetic = self.motion.system.kinetic_energy(observed)
        tilt = observed["tilt"]
        precession, _, spin = (observed[name] for name in TOP_RATES)
        axial = self.inertia_axis * (spin + precession * cos(tilt))
        vertical = _moment_across(self) * precession * sin(tilt) ** 2 + axial * cos(tilt)
        return {
            "energy": kinetic + self.mass * self.gravity * self.length * cos(tilt),
            "vertical_momentum": vertical,
            "axial_momentum": axial,
        }


def _moment_across(p: Any) -> Any:
    """Returns A of eq. 1, the moment of inertia across the axis about the fixed point [kg m^2]."""
    return p.inertia_across + p.mass * p.length**2


def euler_masses(q: Any, around: Any, across: Any, axis: Any) -> tuple[tuple[Any, ...], ...]:
    """Returns the mass matrix for the rates of Euler's angles `q` [rad]. The moment A of eq. 1 is
    `around` for the precession and `across` for the tilt; C is `axis`."""
    cosine = cos(q[1])
    turn = around * sin(q[1]) ** 2 + axis * cosine**2
    return (turn, 0.0, axis * cosine), (0.0, across, 0.0), (axis * cosine, 0.0, axis)


def _masses(p: Any, q: Any) -> tuple[tuple[Any, ...], ...]:
    """Returns the mass matrix of eq. 1 [kg m^2]."""
    return euler_masses(q, _moment_across(p), _moment_across(p), p.inertia_axis)


def _moments(p: Any, time: Any, q: Any, v: Any) -> tuple[Any, Any, Any]:
    """Returns the right-hand side of Lagrange's equations of eq. 1 [N m]."""
    sine = sin(q[1])
    cosine = cos(q[1])
    difference = (_moment_across(p) - p.inertia_axis) * sine * cosine
    axis = p.inertia_axis * sine
    weight = p.mass * p.gravity * p.length * sine
    return (
        axis * v[1] * v[2] - 2 * difference * v[0] * v[1],
        difference * v[0] ** 2 - axis * v[0] * v[2] + weight,
        axis * v[0] * v[1],
    )
