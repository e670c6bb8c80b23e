"""Sensitivity of a rotor's motion to its start."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.taylor_series import integrate
from plumbob.analytic.numerics.rotor.variational import TangentFlow
from plumbob.analytic.reference import Array


def sensitivity(rotor: DrivenRotor, theta: float, theta_dot: float, times: Array) -> Array:
    """Derivatives of (theta, theta_dot) at `times` [s], shape (n,), by the start `theta` [rad],
    `theta_dot` [rad/s], shape (n, 2, 2): rows by what changes, columns by what is varied. Raises
    ParameterError."""
    flow = TangentFlow(
        rotor, integrate(rotor, theta, theta_dot, float(np.max(times, initial=0.0)) or 1.0)
    )
    return flow.respond(np.eye(2), np.zeros((*flow.times.shape, 2, 2))).at(times)
