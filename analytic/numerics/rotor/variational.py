"""Linear response along a motion: w' = J(t) w + q(t), with w = (d theta, d theta_dot).

Every small deviation from a motion obeys this equation: that by a change of the start (q = 0), of a
coefficient (q = the partial derivative of the acceleration), by a scheme's error (q = its defect).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.numerics.collocation import Collocation, TimeGrid, gauss_collocation
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.taylor_series import Orbit
from plumbob.analytic.reference import Array

STAGES = 10  # on the steps of the Taylor series: the response is accurate to about 1e-9, relatively


@dataclass(frozen=True)
class Response:
    """Solutions w(t) along an orbit, one for each column of the forcing."""

    orbit: TimeGrid
    starts: Array  # w at the start of each step, shape (steps, 2, columns)
    end: Array  # w at the end of the last step, shape (2, columns)
    slopes: Array  # w' at the nodes of each step, shape (steps, stages, 2, columns)

    @property
    def _rule(self) -> Collocation:
        return gauss_collocation(self.slopes.shape[1])

    @cached_property
    def _lengths(self) -> Array:
        return np.diff(self.orbit.breakpoints)[:, None, None, None]

    def at(self, times: Array) -> Array:
        """Values at `times` [s], shape (n,), as shape (n, 2, columns). Raises ParameterError."""
        step = self.orbit.locate(times)
        length = np.diff(self.orbit.breakpoints)[step]
        weights = self._rule.integral_to((times - self.orbit.breakpoints[step]) / length)
        gained = (length[:, None] * weights)[:, None] @ _flat(self.slopes)[step]
        return self.starts[step] + gained.reshape(-1, *self.end.shape)

    def followed_by(self, other: Response) -> Response:
        """This response and the `other`, which begins where it ends."""
        edges = np.concatenate([self.orbit.breakpoints, other.orbit.breakpoints[1:]])
        starts = np.concatenate([self.starts, other.starts])
        slopes = np.concatenate([self.slopes, other.slopes])
        return Response(TimeGrid(edges), starts, other.end, slopes)

    def at_nodes(self, derivative: int = 0) -> Array:
        """Values, or time derivatives of the order given, at the nodes of all steps, shape
        (steps, stages, 2, columns)."""
        if derivative == 0:
            gained = (self._rule.integral @ _flat(self.slopes)).reshape(self.slopes.shape)
            return self.starts[:, None] + self._lengths * gained
        values = _flat(self.slopes)
        for _ in range(derivative - 1):
            values = self._rule.derivative @ values / self._lengths[..., 0]
        return values.reshape(self.slopes.shape)


def _flat(slopes: Array) -> Array:
    """The slopes at each node of a step in one row, shape (steps, stages, 2 columns)."""
    return slopes.reshape(*slopes.shape[:2], -1)


def together(responses: Sequence[Response]) -> Response:
    """Responses along one orbit as one, with the columns of all."""
    return Response(
        responses[0].orbit,
        np.concatenate([response.starts for response in responses], axis=-1),
        np.concatenate([response.end for response in responses], axis=-1),
        np.concatenate([response.slopes for response in responses], axis=-1),
    )


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
    def _inverse(self) -> Array:
        """Inverse of the collocation equations of each step, shape (steps, 2 stages, 2 stages)."""
        rule = gauss_collocation(STAGES)
        scaled = np.diff(self.orbit.breakpoints)[:, None, None] * rule.integral
        identity = np.broadcast_to(np.eye(STAGES), scaled.shape)
        system = np.block(
            [
                [identity, -scaled],
                [-self.slope[:, :, None] * scaled, identity + self.rotor.damping_rate * scaled],
            ]
        )
        return np.linalg.inv(system)

    @cached_property
    def _free(self) -> Array:
        """Slopes at the nodes for either component at a step's start, (steps, stages, 2, 2)."""
        matrix = np.zeros((*self.times.shape, 2, 2))
        matrix[..., 0, 1] = 1.0
        matrix[..., 1, 0] = self.slope
        matrix[..., 1, 1] = -self.rotor.damping_rate
        return self._solve(matrix)

    @cached_property
    def transitions(self) -> Array:
        """Fundamental matrix across each step, shape (steps, 2, 2)."""
        return np.eye(2) + self._across(self._free)

    def respond(self, start: Array, forcing: Array) -> Response:
        """Response that begins at `start`, shape (2, columns), under `forcing`, the q at the
        nodes, shape (steps, stages, 2, columns)."""
        forced = self._solve(forcing)
        gained = self._across(forced)
        starts = self._carried(start, gained)
        free = self._free.reshape(len(gained), -1, 2) @ starts[:-1]
        return Response(self.orbit, starts[:-1], starts[-1], forced + free.reshape(forced.shape))

    def _carried(self, start: Array, gained: Array) -> Array:
        """From `start`, the response at the ends of all steps, shape (steps + 1, 2, columns), each
        of which adds what is `gained`, shape (steps, 2, columns)."""
        reached, across = [], self.transitions.reshape(-1, 4).tolist()
        for column, (x, v) in enumerate(start.T.tolist()):  # plain numbers: a step is a few sums
            ends = [(x, v)]
            for (a, b, c, d), (p, q) in zip(across, gained[:, :, column].tolist(), strict=True):
                x, v = a * x + b * v + p, c * x + d * v + q
                ends.append((x, v))
            reached.append(ends)
        return np.moveaxis(np.array(reached), 0, -1)

    def _across(self, slopes: Array) -> Array:
        lengths = np.diff(self.orbit.breakpoints)
        gained = gauss_collocation(STAGES).weights @ _flat(slopes)
        return (lengths[:, None] * gained).reshape(len(lengths), *slopes.shape[2:])

    def _solve(self, sources: Array) -> Array:
        """Node slopes of each step from rest, for `sources` at its nodes, same shape."""
        steps, stages, _, columns = sources.shape
        stacked = sources.transpose(0, 2, 1, 3).reshape(steps, 2 * stages, columns)
        solved = (self._inverse @ stacked).reshape(steps, 2, stages, columns)
        return solved.transpose(0, 2, 1, 3)


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
