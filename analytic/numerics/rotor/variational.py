"""Linear response along a motion: w' = J(t) w + q(t), with w = (d theta, d theta_dot).

Every small deviation from a motion obeys this equation: that by a change of the start (q = 0), of a
coefficient (q = the partial derivative of the acceleration), by a scheme's error (q = its defect).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.numerics.collocation import gauss_collocation
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.linear_flow import LinearFlow, Response
from plumbob.analytic.numerics.rotor.taylor_series import Orbit
from plumbob.analytic.reference import Array

STAGES = 10  # on the steps of the Taylor series: the response is accurate to about 1e-9, relatively


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


def weighted_response(flow: TangentFlow) -> Response:
    """Responses to a relative change of one in each input: theta(0), theta_dot(0), and each
    coefficient that is not zero."""
    x, v = flow.orbit.theta[0], flow.orbit.theta_dot[0]
    partials = flow.rotor.partials(flow.times, *flow.states)
    inputs = {name: getattr(flow.rotor, name) for name in partials}
    scaled = [value * partials[name] for name, value in inputs.items() if value != 0.0]
    forcing = np.zeros((*flow.times.shape, 2, 2 + len(scaled)))
    for column, source in enumerate(scaled, start=2):
        forcing[:, :, 1, column] = source
    start = np.zeros((2, forcing.shape[-1]))
    start[0, 0], start[1, 1] = x, v
    return flow.respond(start, forcing)
