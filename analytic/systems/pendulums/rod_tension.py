"""The tension of a pendulum's rod and the place of its bob as functions of its motion (Pendulo
Simples)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.reference import Array, Signals

MASS = 1.0  # [kg] of the bob unless given: the notebook's code is per unit mass


def tension(
    length: float, gravity: float, theta: Any, theta_dot: Any, mass: float = MASS
) -> Any:
    """T = m L theta'^2 + m g cos theta [N], positive when the rod is pulled; of arrays, shapes
    (n,), or power series."""
    return mass * (length * theta_dot * theta_dot + gravity * np.cos(theta))


def bob_place(length: float, theta: Array) -> Array:
    """x = L sin theta and y = -L cos theta of the bob from the axis [m], y upwards, shape (n, 2);
    theta [rad], shape (n,). The notebook's X_1 and X_2 are -x and -y."""
    return np.column_stack([length * np.sin(theta), -length * np.cos(theta)])


@dataclass(frozen=True)
class RodMotion:
    """An exact `motion` of an angle, with what the `system` of its equation reads off it: a rod's
    tension; a `Reference`."""

    motion: Any  # a `Reference` of theta and theta_dot
    system: SmoothSystem

    @property
    def closed_form(self) -> Any:
        """The motion's closed form; None where there is none."""
        return self.motion.closed_form

    @property
    def rotor(self) -> Any:
        """Its equation."""
        return self.motion.rotor

    def certify(self, last: float, watch: Callable[[float], None]) -> None:
        """Integrate a motion without a closed form up to `last` [s] (see `CertifiedMotion`)."""
        if self.closed_form is None:
            self.motion.certify(last, watch)

    def observe(self, times: Array) -> Signals:
        """theta [rad], theta_dot [rad/s] and tension [N] at `times` [s], shape (n,)."""
        return self.system.observed(self.system.state(self.motion.observe(times)))

    def uncertainty(self, times: Array) -> Signals:
        """Effect of double precision on each observable at `times` [s], shape (n,)."""
        asked = self.motion.observe, self.motion.uncertainty
        return self.system.doubts(*(self.system.state(ask(times)) for ask in asked))

    def nonlinearity(self, times: Array, errors: Signals) -> float:
        """Nonlinearity of the response to errors of theta and theta_dot, shape (n,)."""
        return float(self.motion.nonlinearity(times, errors))
