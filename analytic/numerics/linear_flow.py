"""Linear differential equations w' = A(x) w + q(x) of any size, by Gauss collocation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.numerics.collocation import Collocation, TimeGrid, gauss_collocation
from plumbob.analytic.reference import Array

STEPS_PER_BLOCK = 256  # steps solved at once: a hundred MB at most


@dataclass(frozen=True)
class Response:
    """Solutions w(t) along an orbit, one for each column of the forcing."""

    orbit: TimeGrid
    states: Array  # w at the breakpoints, shape (steps + 1, d, columns)
    slopes: Array  # w' at the nodes of each step, shape (steps, stages, d, columns)

    @property
    def _rule(self) -> Collocation:
        """Collocation rule of the nodes."""
        return gauss_collocation(self.slopes.shape[1])

    @cached_property
    def _lengths(self) -> Array:
        """Lengths of the steps [s], shape (steps, 1, 1, 1)."""
        return np.diff(self.orbit.breakpoints)[:, None, None, None]

    def at(self, times: Array) -> Array:
        """Returns the solutions w at `times` [s], shape (n,), as shape (n, d, columns). Raises
        ParameterError for a time outside the grid."""
        step = self.orbit.locate(times)
        length = np.diff(self.orbit.breakpoints)[step]
        fraction = (times - self.orbit.breakpoints[step]) / length
        weights = length[:, None] * self._rule.integral_to(fraction)
        change = weights[:, None] @ _row_per_node(self.slopes)[step]
        return self.states[step] + change.reshape(-1, *self.states.shape[1:])

    def followed_by(self, later: Response) -> Response:
        """Returns one response that joins this one and the `later` one, which begins at its end."""
        return Response(
            TimeGrid(np.append(self.orbit.breakpoints, later.orbit.breakpoints[1:])),
            np.concatenate([self.states, later.states[1:]]),
            np.concatenate([self.slopes, later.slopes]),
        )

    def at_nodes(self, derivative: int = 0) -> Array:
        """Returns the solutions w, or their time derivatives of order `derivative`, at all nodes.

        The shape is (steps, stages, d, columns).
        """
        if derivative == 0:
            integrals = self._rule.integral @ _row_per_node(self.slopes)
            change = self._lengths * integrals.reshape(self.slopes.shape)
            return self.states[:-1, None] + change
        values = _row_per_node(self.slopes)
        for _ in range(derivative - 1):
            values = self._rule.derivative @ values / self._lengths[..., 0]
        return values.reshape(self.slopes.shape)


def _row_per_node(slopes: Array) -> Array:
    """Returns the slopes with one row for each node, shape (steps, stages, d times columns)."""
    return slopes.reshape(*slopes.shape[:2], -1)


def join_columns(responses: Sequence[Response]) -> Response:
    """Returns one response with the columns of all `responses` along the same orbit."""
    return Response(
        responses[0].orbit,
        np.concatenate([response.states for response in responses], axis=-1),
        np.concatenate([response.slopes for response in responses], axis=-1),
    )


@dataclass(frozen=True)
class LinearFlow:
    """The homogeneous equation w' = A w on a grid of steps."""

    grid: TimeGrid
    matrix: Any  # A at the nodes, real or complex, shape (steps, stages, d, d)

    @cached_property
    def _unit_slopes(self) -> Array:
        """Slopes at the nodes for a unit value of each component at the step's start, shape
        (steps, stages, d, d)."""
        return self._slopes_from_zero(self.matrix)

    @cached_property
    def transitions(self) -> Array:
        """Fundamental matrix of each step, shape (steps, d, d)."""
        return np.eye(self.matrix.shape[-1]) + self._integral_over_step(self._unit_slopes)

    def respond(self, start: Array, forcing: Array) -> Response:
        """Returns the response from `start`, shape (d, columns), under a forcing.

        `forcing` is q at the nodes, shape (steps, stages, d, columns).
        """
        forced_slopes = self._slopes_from_zero(forcing)
        forced_changes = self._integral_over_step(forced_slopes)
        states = [start]
        for transition, change in zip(self.transitions, forced_changes, strict=True):
            states.append(transition @ states[-1] + change)
        slopes = forced_slopes + self._unit_slopes @ np.array(states[:-1])[:, None]
        return Response(self.grid, np.array(states), slopes)

    def _integral_over_step(self, slopes: Array) -> Array:
        """Returns the integral of the slopes over each step, shape (steps, d, columns)."""
        weights = gauss_collocation(slopes.shape[1]).weights
        means = np.einsum("n,snab->sab", weights, slopes)
        return np.asarray(np.diff(self.grid.breakpoints)[:, None, None] * means)

    def _slopes_from_zero(self, sources: Array) -> Array:
        """Returns the slopes at the nodes of each step that starts at w = 0.

        `sources` is the forcing at the nodes; the result has its shape.
        """
        steps, stages, size, _ = self.matrix.shape
        unknowns = stages * size
        lengths = np.diff(self.grid.breakpoints)[:, None, None]
        integrals = lengths * gauss_collocation(stages).integral
        slopes = np.empty(sources.shape, np.result_type(sources, self.matrix))
        # The slopes k_i = A_i (w + length sum_j a_ij k_j) + q_i are solved for all nodes of a step
        # together.
        for first in range(0, steps, STEPS_PER_BLOCK):
            block = slice(first, first + STEPS_PER_BLOCK)
            coupling = -np.einsum("sij,siab->siajb", integrals[block], self.matrix[block])
            system = coupling.reshape(-1, unknowns, unknowns) + np.eye(unknowns)
            right = sources[block].reshape(len(system), unknowns, -1)
            slopes[block] = np.linalg.solve(system, right).reshape(slopes[block].shape)
        return slopes
