"""Linear response along a motion: w' = J(t) w + q(t), with w = (d theta, d theta_dot).

Every small deviation from a motion obeys this equation: that by a change of the start (q = 0), of a
coefficient (q = the partial derivative of the acceleration), by a scheme's error (q = its defect).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from plumbob.analytic.numerics.collocation import gauss_collocation
from plumbob.analytic.numerics.linear_flow import LinearFlow, Response
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.orbit import Orbit, integrate
from plumbob.analytic.reference import Array

STAGES = 10  # on the steps of an orbit: the response is accurate to about 1e-9, relatively


@dataclass(frozen=True)
class TangentFlow:
    """The motion's linearisation, solved on every step by Gauss collocation of order 16."""

    rotor: DrivenRotor
    orbit: Orbit

    @cached_property
    def times(self) -> Array:
        """Times of the nodes [s], shape (steps, stages)."""
        edges = self.orbit.breakpoints
        nodes = edges[:-1, None] + np.diff(edges)[:, None] * gauss_collocation(STAGES).nodes
        return np.asarray(np.minimum(nodes, edges[-1]))

    @cached_property
    def states(self) -> tuple[Array, Array]:
        """Theta and theta_dot at the nodes, each of shape (steps, stages)."""
        return self.orbit.at(self.times)

    @cached_property
    def slope(self) -> Array:
        """Partial derivative of the acceleration by theta at the nodes, shape (steps, stages)."""
        return self.rotor.slope(self.states[0])

    @cached_property
    def _linear(self) -> LinearFlow:
        matrix = np.zeros((*self.times.shape, 2, 2))
        matrix[..., 0, 1] = 1.0
        matrix[..., 1, 0] = self.slope
        matrix[..., 1, 1] = -self.rotor.damping_rate
        return LinearFlow(self.orbit, matrix)

    @property
    def transitions(self) -> Array:
        """Fundamental matrix across each step, shape (steps, 2, 2)."""
        return self._linear.transitions

    def respond(self, start: Array, forcing: Array) -> Response:
        """Response that begins at `start`, shape (2, columns), under `forcing`, the q at the
        nodes, shape (steps, stages, 2, columns)."""
        return self._linear.respond(start, forcing)


@lru_cache(maxsize=4)  # the same for all schemes of one motion
def tangent_flow(
    rotor: DrivenRotor, theta: float, theta_dot: float, duration: float
) -> TangentFlow:
    """The linearisation along the motion of `rotor` from `theta` [rad], `theta_dot` [rad/s] for
    `duration` [s]. Raises ParameterError."""
    return TangentFlow(rotor, integrate(rotor, theta, theta_dot, duration))


def sensitivity(rotor: DrivenRotor, theta: float, theta_dot: float, times: Array) -> Array:
    """Derivatives of (theta, theta_dot) at `times` [s] by the start, shape (n, 2, 2).
    Raises ParameterError."""
    flow = tangent_flow(rotor, theta, theta_dot, float(np.max(times, initial=0.0)) or 1.0)
    return flow.respond(np.eye(2), np.zeros((*flow.times.shape, 2, 2))).at(times)
