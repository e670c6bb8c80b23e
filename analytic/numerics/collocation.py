"""Collocation on the unit interval: Gauss and Radau rules, their operators, an implicit solver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array

MAX_NEWTON_ITERATIONS = 12  # largest number of Newton steps
# All sizes of Newton steps are relative to the scale of the state.
CONVERGED = 1e-15  # size of a step at which the iteration has converged
ROUNDOFF_STEP = 1e-12  # size below which a step that no longer shrinks is round-off
DIVERGED_SIZE = 1e6  # size beyond which the iteration has diverged
REUSED_MATRIX_STEP = 1e-4  # size below which the next step uses the same matrix again
STEP_RATIO_FOR_NEW_MATRIX = 0.1  # ratio of two steps beyond which the second needs a new matrix
LARGEST_EXPONENT = 3.0  # largest growth of a first guess, in e-folds

RightHandSide = Callable[[Array, bool], tuple[Array, Array]]
"""Function from the states at the nodes to their slopes and, if its second argument is true, the
derivatives of the slopes."""


@dataclass(frozen=True)
class TimeGrid:
    """Steps in which a motion is computed, from time 0 on."""

    breakpoints: Array  # [s], shape (steps + 1,)

    @property
    def duration(self) -> float:
        """Time of the last breakpoint [s]."""
        return float(self.breakpoints[-1])

    def locate(self, times: Array) -> npt.NDArray[np.intp]:
        """Returns the index of the step in which each of `times` [s] lies. Raises ParameterError
        for a time outside the grid."""
        times = np.asarray(times, dtype=float)
        if times.size and not (times.min() >= 0.0 and times.max() <= self.duration):
            worst = times.min() if not times.min() >= 0.0 else times.max()
            raise ParameterError("times", float(worst), f"between 0 and {self.duration} s")
        last = len(self.breakpoints) - 2
        return np.minimum(np.searchsorted(self.breakpoints, times, side="right") - 1, last)


@dataclass(frozen=True)
class Collocation:
    """A rule of n nodes on (0, 1] and the operators that act on values at its nodes.

    Legendre coefficients belong to Legendre polynomials in 2 c - 1, for c in [0, 1].
    """

    nodes: Array  # shape (n,)
    weights: Array  # weights of the integral over (0, 1), shape (n,)
    integral: Array  # row i integrates from 0 to node i, shape (n, n)
    derivative: Array  # row i differentiates at node i, shape (n, n)
    spectrum: Array  # row k gives the Legendre coefficient of degree k, shape (n, n)
    antiderivative: Array  # integral from 0, on Legendre coefficients, shape (n + 1, n)

    def integral_to(self, fractions: Array) -> Array:
        """Returns rows that integrate from 0 to each of m `fractions`, shape (m, n)."""
        return basis(fractions, len(self.nodes) + 1) @ self.antiderivative @ self.spectrum

    def primitive(self, start: Array, slopes: Array) -> Array:
        """Returns the Legendre coefficients of a state in its step, shape (n + 1, d).

        The state is `start`, shape (d,), plus the integral of the polynomial through `slopes` at
        the nodes, shape (n, d).
        """
        coefficients = self.antiderivative @ (self.spectrum @ slopes)
        coefficients[0] += start
        return coefficients

    def shortened(self, slopes: Array, part: float) -> Array:
        """Returns the slopes at the nodes of a shorter step, shape (n, d).

        The shorter step is the first fraction `part` of a step with `slopes` at its nodes.
        """
        return part * basis(part * self.nodes, len(slopes)) @ (self.spectrum @ slopes)

    def truncation(self, slopes: Array, scale: Array) -> float:
        """Returns the truncation error of a solution over its `scale`, shape (d,).

        It is the size of the last three Legendre coefficients of its `slopes`, shape (n, d).
        """
        last = np.abs(self.spectrum[-3:] @ slopes).max(axis=0)
        return float(np.max(last / scale) / len(slopes))


@lru_cache(maxsize=4)
def gauss_collocation(stages: int) -> Collocation:
    """Returns the Gauss-Legendre rule of `stages` nodes.

    Its collocation method has the order 2 stages (Hairer, Lubich and Wanner 2006, Geometric
    Numerical Integration, II.1).
    """
    return _collocation(legendre.leggauss(stages)[0])


@lru_cache(maxsize=8)
def radau_collocation(stages: int) -> Collocation:
    """Returns the Radau IIA rule of `stages` nodes, the last at 1.

    Its collocation method has the order 2 stages - 1 and is stiffly accurate (Hairer and Wanner
    1996, Solving Ordinary Differential Equations II, IV.5).
    """
    from scipy.special import roots_jacobi

    return _collocation(np.append(np.asarray(roots_jacobi(stages - 1, 1.0, 0.0)[0]), 1.0))


def _collocation(points: Array) -> Collocation:
    """Returns the rule with nodes at `points` of (-1, 1], shape (n,)."""
    stages = len(points)
    nodes = (points + 1.0) / 2.0
    spectrum = np.linalg.inv(
        np.asarray(legendre.legvander(points, stages - 1), dtype=np.float64)
    )
    slopes = 2.0 * legendre.legvander(points, stages - 2) @ legendre.legder(spectrum)
    # The columns are the integrals from 0 of the shifted Legendre polynomials.
    antiderivative = np.asarray(0.5 * legendre.legint(np.eye(stages), lbnd=-1.0), np.float64)
    *integral, weights = basis(np.append(nodes, 1.0), stages + 1) @ antiderivative @ spectrum
    return Collocation(
        nodes=nodes,
        weights=weights,
        integral=np.array(integral),
        derivative=np.asarray(slopes),
        spectrum=spectrum,
        antiderivative=antiderivative,
    )


def basis(places: Array, count: int) -> Array:
    """Returns the first `count` shifted Legendre polynomials at `places` in [0, 1], shape (n,), as
    shape (n, count)."""
    return np.asarray(legendre.legvander(2.0 * places - 1.0, count - 1), dtype=np.float64)


def evaluate(coefficients: Array, places: Array) -> Array:
    """Returns polynomials at `places` in [0, 1], shape (n,), as shape (n, d), from their Legendre
    `coefficients`, shape (k, d)."""
    return np.asarray(legendre.legval(2.0 * places - 1.0, coefficients, tensor=True).T)


def collocate(
    rule: Collocation,
    right_hand_side: RightHandSide,
    start: Array,
    guess: Array,
    scale: Array,
    *,
    all_derivatives: bool = True,
) -> Array | None:
    """Returns the slopes dz/dc at the nodes, shape (n, d), of the polynomial z(c) that solves
    dz/dc = f(z) at the nodes; None if Newton's iteration does not converge.

    `right_hand_side` maps states (n, d) to slopes (n, d) and, if asked, to their derivatives
    (n, d, k) by the first k components of the state. If f depends weakly on the other components,
    or in other ways on the first k, `all_derivatives` is False. `start` (d,) is the state at c = 0,
    `guess` (n, d) the first slopes, `scale` (d,) the size of the state.
    """
    slopes = guess.copy()
    previous = 0.0
    last_step = False
    newton = None
    for _ in range(MAX_NEWTON_ITERATIONS):
        needs_matrix = newton is None
        value, derivative = right_hand_side(start + rule.integral @ slopes, needs_matrix)
        if needs_matrix:
            newton = _newton_correction(rule, derivative)
        if newton is None or not np.isfinite(value.sum()):
            return None
        correction = newton(value - slopes)
        slopes += correction
        step = float((np.abs(rule.integral @ correction) / scale).max())
        # Newton's method converges quadratically, with an old matrix linearly. In both cases the
        # next step is below step^2/previous. If derivatives are left out, the next step is taken
        # all the same: a small part of the error converges more slowly than the steps so far.
        next_is_negligible = step * step <= CONVERGED * previous
        stalled = ROUNDOFF_STEP > step > previous
        if step <= CONVERGED or stalled or last_step:
            return slopes
        if next_is_negligible and all_derivatives:
            return slopes
        last_step = next_is_negligible
        if step > DIVERGED_SIZE:
            return None
        converges_slowly = not needs_matrix and step > STEP_RATIO_FOR_NEW_MATRIX * previous
        if step > REUSED_MATRIX_STEP or converges_slowly:
            newton = None
        previous = step
    return None


def _newton_correction(rule: Collocation, derivative: Array) -> Callable[[Array], Array] | None:
    """Returns a function that replaces a residual of the slopes, shape (n, d), by Newton's
    correction.

    `derivative` has the derivatives at the nodes, shape (n, d, k). The correction is implicit in
    the first k components, then explicit in the others. Returns None if the matrix is singular, or
    the derivatives are not finite.
    """
    from scipy.linalg.lapack import dgetrf, dgetrs

    if not np.isfinite(derivative.sum()):
        return None
    count, _, implicit = derivative.shape
    implicit_derivative = derivative[:, :implicit].transpose(2, 0, 1)
    explicit_derivative = derivative[:, implicit:]
    integrals = -rule.integral.T[:, None, :, None]
    matrix = np.multiply(integrals, implicit_derivative[None]).reshape(-1)
    matrix[:: count * implicit + 1] += 1.0
    square = matrix.reshape(count * implicit, count * implicit).T
    factors, pivots, singular = dgetrf(square, overwrite_a=True)

    def correction(residual: Array) -> Array:
        # LAPACK takes a single column as a vector.
        """Returns the correction of the slopes, which overwrites the `residual`."""
        right: Any = residual[:, :implicit].reshape(-1)
        residual[:, :implicit] = dgetrs(factors, pivots, right)[0].reshape(-1, implicit)
        if implicit < residual.shape[1]:
            change = rule.integral @ residual[:, :implicit]
            residual[:, implicit:] += (explicit_derivative @ change[:, :, None])[:, :, 0]
        return residual

    return None if singular else correction


def linearised(rates: Array, derivative: Array, lengths: Array) -> Array:
    """Returns the rates at `lengths`, shape (n,), ahead of a state, as shape (n, d).

    The state has the `rates` f, shape (d,). Their `derivative` J by the first k components of the
    state, shape (d, k), is taken as constant, so that the rates are exp(length J) f. They are a
    first guess that follows decaying components.
    """
    count = derivative.shape[1]
    values, vectors = np.linalg.eig(derivative[:count])
    try:
        weights = np.linalg.solve(vectors, rates[:count].astype(complex))
    except np.linalg.LinAlgError:
        return np.repeat(rates[None, :], lengths.size, axis=0)
    rows = lengths[:, None]
    folds = np.minimum(rows * values.real, LARGEST_EXPONENT)
    growth = np.exp(folds + 1j * rows * values.imag)
    rates_ahead = np.empty((lengths.size, rates.size))
    rates_ahead[:, :count] = ((growth * weights) @ vectors.T).real
    with np.errstate(all="ignore"):
        integrals = np.where(values == 0.0, rows, (growth - 1.0) / values)
    change = ((integrals * weights) @ vectors.T).real
    rates_ahead[:, count:] = rates[count:] + change @ derivative[count:].T
    return rates_ahead
