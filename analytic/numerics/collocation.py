"""Gauss collocation on the unit interval: nodes, weights, and the operators between node values."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from plumbob.analytic.reference import Array


@dataclass(frozen=True)
class Collocation:
    """Gauss-Legendre rule of `stages` nodes on (0, 1) and what goes with it (Hairer, Lubich and
    Wanner 2006, Geometric Numerical Integration, II.1); every operator acts on node values."""

    nodes: Array  # shape (stages,)
    weights: Array  # of the integral over (0, 1), shape (stages,)
    integral: Array  # row i integrates from 0 to node i, shape (stages, stages)
    derivative: Array  # row i differentiates at node i, shape (stages, stages)
    spectrum: Array  # row n gives the Legendre coefficient of degree n, shape (stages, stages)

    def integral_to(self, fractions: Array) -> Array:
        """Rows that integrate from 0 to each of `fractions`, shape (n,); result (n, stages)."""
        return _integrated_legendre(fractions, len(self.nodes)) @ self.spectrum


@lru_cache(maxsize=4)
def gauss_collocation(stages: int) -> Collocation:
    """Return the Gauss rule of `stages` nodes; the collocation method on it has order 2 stages."""
    points, weights = legendre.leggauss(stages)
    values = legendre.legvander(points, stages - 1)
    spectrum = (2 * np.arange(stages) + 1)[:, None] / 2 * values.T * weights
    nodes = (points + 1) / 2
    slopes = np.array([legendre.legval(points, legendre.legder(row)) for row in np.eye(stages)])
    return Collocation(
        nodes,
        weights / 2,
        _integrated_legendre(nodes, stages) @ spectrum,
        2 * slopes.T @ spectrum,
        spectrum,
    )


def _integrated_legendre(fractions: Array, stages: int) -> Array:
    """Integral from 0 of the shifted Legendre polynomials of degree below `stages`."""
    ladder = legendre.legvander(2 * np.asarray(fractions, dtype=float) - 1, stages)
    degree = np.arange(1, stages)
    first = (ladder[:, :1] + ladder[:, 1:2]) / 2
    return np.hstack([first, (ladder[:, 2:] - ladder[:, :-2]) / (2 * (2 * degree + 1))])
