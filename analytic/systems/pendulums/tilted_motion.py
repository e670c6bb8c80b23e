"""A pendulum's motion seen from an axis that is tilted by a constant angle.

A product of inertia turns the principal axes of a body out of the plane in which its angle is
measured; the closed form holds in the principal axes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.elliptic.motion import EllipticMotion
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion


@dataclass(frozen=True)
class TiltedMotion:
    """Motion of theta = phi - `tilt` [rad], phi being the angle of `principal`; a `Reference`."""

    principal: PendulumMotion
    tilt: float

    @property
    def closed_form(self) -> EllipticMotion:
        """The constants of the closed form of phi."""
        return self.principal.closed_form

    def state(self, times: Array) -> tuple[Array, Array]:
        """theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,)."""
        phi, rate = self.principal.state(times)
        return phi - self.tilt, rate

    def time_at(self, theta: Array) -> Array:
        """When the motion first reaches `theta` [rad] after the start [s]; NaN where never."""
        return self.principal.time_at(np.asarray(theta, dtype=float) + self.tilt)

    def momentum(self, theta: Array) -> Array:
        """p(H, theta) [kg m^2 rad/s] with the sign of the start; NaN where out of reach."""
        return self.principal.momentum(np.asarray(theta, dtype=float) + self.tilt)

    def observe(self, times: Array) -> Mapping[str, Array]:
        """theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,)."""
        theta, theta_dot = self.state(times)
        return {"theta": theta, "theta_dot": theta_dot}

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Effect of double precision: that on phi, where the start's rounding is part of it, and
        two roundings of the tilt."""
        known = self.principal.uncertainty(times)
        return {**known, "theta": known["theta"] + 2 * ULP * abs(self.tilt)}

    def nonlinearity(self, times: Array, errors: Mapping[str, Array]) -> float:
        """That of phi."""
        return self.principal.nonlinearity(times, errors)
