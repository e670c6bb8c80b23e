"""The tension of a pendulum's rod and the position of its bob as functions of its motion (Pendulo
Simples)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.reference import Array, Signals

MASS = 1.0  # [kg] default mass of the bob: the notebook's code is per unit mass


def tension(
    length: float, gravity: float, theta: Any, theta_dot: Any, mass: float = MASS
) -> Any:
    """Returns T = m L theta'^2 + m g cos theta [N], positive if the rod is pulled. The angle theta
    [rad] and its rate [rad/s] are arrays of shape (n,) or power series."""
    return mass * (length * theta_dot * theta_dot + gravity * np.cos(theta))


def bob_place(length: float, theta: Array) -> Array:
    """Returns x = L sin theta and y = -L cos theta of the bob from the axis [m], y upwards, shape
    (n, 2), from theta [rad], shape (n,). The notebook's X_1 and X_2 are -x and -y."""
    return np.column_stack([length * np.sin(theta), -length * np.cos(theta)])


@dataclass(frozen=True)
class RodMotion:
    """A `Reference` that adds the rod's tension to an exact `motion` of the angle. The `system` of
    its equation computes the tension from the state."""

    motion: Any  # a `Reference` with the observables theta and theta_dot
    system: SmoothSystem

    @property
    def closed_form(self) -> Any:
        """The motion's closed form, or None."""
        return self.motion.closed_form

    @property
    def rotor(self) -> Any:
        """The motion's equation."""
        return self.motion.rotor

    def certify(self, last: float, watch: Callable[[float], None]) -> None:
        """Integrates the motion up to `last` [s] if it has no closed form (see
        `CertifiedMotion`)."""
        if self.closed_form is None:
            self.motion.certify(last, watch)

    def observe(self, times: Array) -> Signals:
        """Exact theta [rad], theta_dot [rad/s] and tension [N] at `times` [s], shape (n,)."""
        return self.system.observed(self.system.state(self.motion.observe(times)))

    def uncertainty(self, times: Array) -> Signals:
        """Error of each observable by double precision at `times` [s], shape (n,)."""
        state = self.system.state(self.motion.observe(times))
        errors = self.system.state(self.motion.uncertainty(times))
        return self.system.doubts(state, errors)

    def nonlinearity(self, times: Array, errors: Signals) -> float:
        """Nonlinearity of the response to errors of theta and theta_dot, shape (n,) each."""
        return float(self.motion.nonlinearity(times, errors))
