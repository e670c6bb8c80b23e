"""The tension of a pendulum's rod beside its motion, errors and all (Pendulo Simples)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plumbob.analytic.errors.joint_series import JointedSeries
from plumbob.analytic.errors.joint_step import CLOSING
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.truncated_series import constant, product, sine_cosine
from plumbob.analytic.reference import Array

MASS = 1.0  # [kg] of the bob: the notebook's equations are per unit mass
_ULP = 2.0**-52
Coefficients = Mapping[int, Mapping[str, Array]]


def tension(length: float, gravity: float, theta: Array, theta_dot: Array) -> Array:
    """T = m L theta'^2 + m g cos theta [N], positive when the rod is pulled; shapes (n,)."""
    return np.asarray(MASS * (length * theta_dot**2 + gravity * np.cos(theta)))


@dataclass(frozen=True)
class RodMotion:
    """A pendulum's `motion`, which obeys `rotor` from `theta` [rad] and `theta_dot` [rad/s], with
    the tension of its rod of `length` [m] under `gravity` [m/s^2]; a `Reference`."""

    motion: Any  # a `Reference` of theta and theta_dot, with whatever else it knows of itself
    rotor: DrivenRotor
    theta: float
    theta_dot: float
    length: float
    gravity: float
    _jointed: list[JointedSeries] = field(default_factory=list, compare=False, repr=False)

    @property
    def closed_form(self) -> Any:
        """The motion's closed form; None where there is none."""
        return self.motion.closed_form

    def observe(self, times: Array) -> Mapping[str, Array]:
        """theta [rad], theta_dot [rad/s] and tension [N] at `times` [s], shape (n,)."""
        seen = self.motion.observe(times)
        pull = tension(self.length, self.gravity, seen["theta"], seen["theta_dot"])
        return {**seen, "tension": pull}

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """What double precision allows each observable, shape (n,)."""
        seen, doubt = self.motion.observe(times), self.motion.uncertainty(times)
        theta, rate = seen["theta"], seen["theta_dot"]
        by_theta = np.abs(self.gravity * np.sin(theta)) * doubt["theta"]
        by_rate = np.abs(2 * self.length * rate) * doubt["theta_dot"]
        parts = self.length * rate**2 + self.gravity * np.abs(np.cos(theta))
        return {**doubt, "tension": MASS * (by_theta + by_rate + 3 * _ULP * parts)}

    def leading_error(self, scheme: str, times: Array) -> Coefficients:
        """Coefficients of the error of `scheme` in each observable, shape (n,): in the tension, by
        its power series in those of theta and theta_dot, and what a joint's pull adds itself."""
        if scheme not in CLOSING:
            return self._with_tension(self.motion.leading_error(scheme, times), times)
        if not self._jointed:
            self._jointed.append(JointedSeries(self.rotor, self.theta, self.theta_dot))
        return self._with_tension(self._jointed[0].at(scheme, times), times)

    def nonlinearity(self, times: Array, errors: Mapping[str, Array]) -> float:
        """How far errors of theta and theta_dot leave their linear response."""
        return float(self.motion.nonlinearity(times, errors))

    def _with_tension(self, terms: Coefficients, times: Array) -> Coefficients:
        if not terms:
            return {}
        seen, degree = self.motion.observe(times), max(terms)
        theta, rate = (constant(seen[name], degree) for name in ("theta", "theta_dot"))
        for power, coefficients in terms.items():
            theta[power], rate[power] = coefficients["theta"], coefficients["theta_dot"]
        series = self.length * product(rate, rate) + self.gravity * sine_cosine(theta)[1]
        return {
            power: {
                "theta": coefficients["theta"],
                "theta_dot": coefficients["theta_dot"],
                "tension": MASS * (series[power] + self.length * coefficients.get("excess", 0.0)),
            }
            for power, coefficients in terms.items()
        }
