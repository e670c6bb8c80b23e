"""The tension of a pendulum's rod and the place of its bob as functions of its motion (Pendulo
Simples)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.reference import Array

MASS = 1.0  # [kg] of the bob unless given: the notebook's code is per unit mass


def tension(length: float, gravity: float, theta: Any, theta_dot: Any, mass: float = MASS) -> Any:
    """T = m L theta'^2 + m g cos theta [N], positive when the rod is pulled; of arrays, shapes
    (n,), or power series."""
    return mass * (length * theta_dot * theta_dot + gravity * np.cos(theta))


def bob_place(length: float, theta: Array) -> Array:
    """x = L sin theta and y = -L cos theta of the bob from the axis [m], y upwards, shape (n, 2);
    theta [rad], shape (n,). The notebook's X_1 and X_2 are -x and -y."""
    return np.column_stack([length * np.sin(theta), -length * np.cos(theta)])


@dataclass(frozen=True)
class RodMotion:
    """A pendulum's `motion`, which obeys `rotor`, with the tension of its rod of `length` [m] under
    `gravity` [m/s^2] with a bob of `mass` [kg]; a `Reference`."""

    motion: Any  # a `Reference` of theta and theta_dot
    rotor: DrivenRotor
    length: float
    gravity: float
    mass: float = MASS

    @property
    def closed_form(self) -> Any:
        """The motion's closed form; None where there is none."""
        return self.motion.closed_form

    def observe(self, times: Array) -> Mapping[str, Array]:
        """theta [rad], theta_dot [rad/s] and tension [N] at `times` [s], shape (n,)."""
        observed = self.motion.observe(times)
        pull = tension(
            self.length, self.gravity, observed["theta"], observed["theta_dot"], self.mass
        )
        return {**observed, "tension": pull}

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Effect of double precision on each observable at `times` [s], shape (n,)."""
        observed, uncertain = self.motion.observe(times), self.motion.uncertainty(times)
        theta, rate = observed["theta"], observed["theta_dot"]
        by_theta = np.abs(self.gravity * np.sin(theta)) * uncertain["theta"]
        by_rate = np.abs(2 * self.length * rate) * uncertain["theta_dot"]
        parts = self.length * rate**2 + self.gravity * np.abs(np.cos(theta))
        return {**uncertain, "tension": self.mass * (by_theta + by_rate + 3 * ULP * parts)}

    def nonlinearity(self, times: Array, errors: Mapping[str, Array]) -> float:
        """Nonlinearity of the response to errors of theta and theta_dot, shape (n,)."""
        return float(self.motion.nonlinearity(times, errors))
