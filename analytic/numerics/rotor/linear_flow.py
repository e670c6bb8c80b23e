"""Linear response of any size: w' = A(x) w + q(x) on steps in x, by Gauss collocation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.numerics.collocation import TimeGrid, gauss_collocation
from plumbob.analytic.numerics.rotor.variational import Response
from plumbob.analytic.reference import Array

BLOCK = 256  # steps solved at once: a hundred MB at most


@dataclass(frozen=True)
class LinearFlow:
    """The homogeneous equation on a grid of steps, its matrix at the nodes of each."""

    grid: TimeGrid
    matrix: Array  # A, shape (steps, stages, d, d)

    @cached_property
    def _lengths(self) -> Array:
        return np.diff(self.grid.breakpoints)

    def respond(self, start: Array, forcing: Array) -> Response:
        """Response that begins at `start`, shape (d, columns), under `forcing`, the q at the nodes,
        shape (steps, stages, d, columns)."""
        blocks = range(0, len(self._lengths), BLOCK)
        solved = [self._solved(slice(k, k + BLOCK), forcing[k : k + BLOCK]) for k in blocks]
        free, forced = (np.concatenate(part) for part in zip(*solved, strict=True))
        weights = gauss_collocation(self.matrix.shape[1]).weights
        across, gained = (
            self._lengths[:, None, None] * np.einsum("n,snab->sab", weights, slopes)
            for slopes in (free, forced)
        )
        states = [start]
        for whole, part in zip(across, gained, strict=True):
            states.append(states[-1] + whole @ states[-1] + part)
        starts = np.array(states)
        slopes = forced + free @ starts[:-1, None]
        return Response(self.grid, starts[:-1], starts[-1], slopes)

    def _solved(self, block: slice, forcing: Array) -> tuple[Array, Array]:
        """Slopes at the nodes of a block of steps for each component at a step's start, (steps,
        stages, d, d), and from rest under `forcing`."""
        matrix, lengths = self.matrix[block], self._lengths[block]
        steps, stages, size, _ = matrix.shape
        rule = gauss_collocation(stages)
        # Slopes k_i = A_i (w + length sum_j a_ij k_j) + q_i, all nodes of a step together.
        scaled = lengths[:, None, None] * rule.integral
        system = -np.einsum("sij,siab->siajb", scaled, matrix)
        flat = system.reshape(steps, stages * size, stages * size)
        flat += np.eye(stages * size)
        right = np.concatenate([matrix, forcing], axis=-1).reshape(steps, stages * size, -1)
        found = np.linalg.solve(flat, right).reshape(steps, stages, size, -1)
        return found[..., :size], found[..., size:]
