"""Collocation on the unit interval: Gauss and Radau rules, their operators, an implicit solver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from plumbob.analytic.reference import Array

ITERATIONS = 12
CONVERGED = 1e-15  # Newton step over the scale of the state
STALLED = 1e-12  # below this a step that no longer shrinks is round-off
DIVERGED = 1e6  # Newton step over the scale of the state
LARGEST_EXPONENT = 3.0  # a first guess needs no faster growth than this

RightHandSide = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Collocation:
    """A rule of n nodes on (0, 1] and the operators that act on values at its nodes.

    Legendre coefficients are those of polynomials in 2 c - 1, for c in [0, 1].
    """

    nodes: Array  # shape (n,)
    weights: Array  # of the integral over (0, 1), shape (n,)
    integral: Array  # row i integrates from 0 to node i, shape (n, n)
    derivative: Array  # row i differentiates at node i, shape (n, n)
    spectrum: Array  # row k gives the Legendre coefficient of degree k, shape (n, n)
    antiderivative: Array  # Legendre coefficients -> those of the integral from 0, (n + 1, n)

    def integral_to(self, fractions: Array) -> Array:
        """Rows that integrate from 0 to each of `fractions`, shape (m,); result (m, n)."""
        return _integrated_legendre(fractions, len(self.nodes)) @ self.spectrum

    def primitive(self, start: Array, slopes: Array) -> Array:
        """Legendre coefficients, shape (n + 1, d), of `start`, shape (d,), plus the integral of the
        polynomial through `slopes`, shape (n, d), at the nodes."""
        coefficients = self.antiderivative @ (self.spectrum @ slopes)
        coefficients[0] += start
        return np.asarray(coefficients)

    def truncation(self, slopes: Array, scale: Array) -> float:
        """Truncation error of the solution with `slopes`, shape (n, d), over its `scale`, shape
        (d,): the size of its last three Legendre coefficients."""
        last = np.abs(self.spectrum[-3:] @ slopes).max(axis=0)
        return float(np.max(last / scale) / len(slopes))


@lru_cache(maxsize=4)
def gauss_collocation(stages: int) -> Collocation:
    """The Gauss-Legendre rule of `stages` nodes; its collocation method has order 2 stages
    (Hairer, Lubich and Wanner 2006, Geometric Numerical Integration, II.1)."""
    points, weights = legendre.leggauss(stages)
    values = legendre.legvander(points, stages - 1)
    spectrum = (2 * np.arange(stages) + 1)[:, None] / 2 * values.T * weights
    nodes = (points + 1) / 2
    slopes = np.array([legendre.legval(points, legendre.legder(row)) for row in np.eye(stages)])
    return Collocation(
        nodes=nodes,
        weights=weights / 2,
        integral=_integrated_legendre(nodes, stages) @ spectrum,
        derivative=2 * slopes.T @ spectrum,
        spectrum=spectrum,
        antiderivative=_antiderivative(stages),
    )


@lru_cache(maxsize=8)
def radau_collocation(stages: int) -> Collocation:
    """The Radau IIA rule of `stages` nodes, the last at 1: order 2 stages - 1 and stiffly accurate
    (Hairer and Wanner 1996, Solving Ordinary Differential Equations II, IV.5)."""
    from scipy.special import roots_jacobi

    x = np.append(np.asarray(roots_jacobi(stages - 1, 1.0, 0.0)[0]), 1.0)
    spectrum = np.linalg.inv(legendre.legvander(x, stages - 1))
    antiderivative = _antiderivative(stages)
    integral = legendre.legvander(x, stages) @ antiderivative @ spectrum
    derivative = 2.0 * legendre.legvander(x, stages - 2) @ legendre.legder(spectrum)
    return Collocation(
        nodes=0.5 * (x + 1.0),
        weights=integral[-1],
        integral=integral,
        derivative=np.asarray(derivative),
        spectrum=spectrum,
        antiderivative=antiderivative,
    )


def _antiderivative(stages: int) -> Array:
    """Legendre coefficients of the integral from 0 of the shifted Legendre polynomials."""
    return np.asarray(0.5 * legendre.legint(np.eye(stages), lbnd=-1.0))


def _integrated_legendre(fractions: Array, stages: int) -> Array:
    """Integral from 0 to `fractions` of the shifted Legendre polynomials of degree below `stages`,
    by (2k + 1) P_k = P'_{k+1} - P'_{k-1}."""
    values = legendre.legvander(2 * np.asarray(fractions, dtype=float) - 1, stages)
    degree = np.arange(1, stages)
    first = (values[:, :1] + values[:, 1:2]) / 2
    return np.hstack([first, (values[:, 2:] - values[:, :-2]) / (2 * (2 * degree + 1))])


def basis(places: Array, count: int) -> Array:
    """Values, shape (n, count), of the first `count` shifted Legendre polynomials at `places` in
    [0, 1], shape (n,); by their recurrence, as `legvander`, with half of its operations."""
    x, values = 2.0 * places - 1.0, np.empty((count, places.size))
    values[0] = 1.0
    if count > 1:
        values[1] = x
    part = np.empty(places.size)
    for k in range(2, count):
        np.multiply(x, values[k - 1], out=values[k])
        values[k] *= (2.0 * k - 1.0) / k
        np.multiply(values[k - 2], (k - 1.0) / k, out=part)
        values[k] -= part
    return values.T


def evaluate(coefficients: Array, places: Array) -> Array:
    """Values, shape (n, d), at `places` in [0, 1], shape (n,), of polynomials with Legendre
    `coefficients`, shape (k, d)."""
    return np.asarray(legendre.legval(2.0 * places - 1.0, coefficients, tensor=True).T)


def collocate(
    rule: Collocation, right_hand_side: RightHandSide, start: Array, guess: Array, scale: Array
) -> Array | None:
    """Slopes dz/dc at the nodes, shape (n, d), of the polynomial that solves dz/dc = f(z) there, or
    None if Newton's iteration does not converge.

    `right_hand_side` maps states (n, d) to slopes (n, d) and their derivatives (n, d, k) by the
    first k components of the state; f may depend weakly on the others. `start` (d,) is the state
    at c = 0, `guess` (n, d) the first slopes, `scale` (d,) the size of the state.
    """
    slopes, previous = guess.copy(), 0.0
    for _ in range(ITERATIONS):
        value, derivative = right_hand_side(start + rule.integral @ slopes)
        if not np.isfinite(derivative.sum() + value.sum()):
            return None
        correction = _newton_correction(rule, value - slopes, derivative)
        if correction is None:
            return None
        slopes += correction
        step = float((np.abs(rule.integral @ correction) / scale).max())
        # Newton's method converges quadratically: the next step is below step^2/previous.
        if step <= CONVERGED or step * step <= CONVERGED * previous or STALLED > step > previous:
            return slopes
        if step > DIVERGED:
            return None
        previous = step
    return None


def _newton_correction(rule: Collocation, residual: Array, derivative: Array) -> Array | None:
    """Newton's correction of the slopes, shape (n, d), implicit in the first k components and then
    explicit in the rest; None where the matrix is singular."""
    (count, width), stiff = residual.shape, derivative.shape[2]
    coupling = -rule.integral[:, None, :, None] * derivative[:, :stiff, None, :]
    matrix = coupling.reshape(count * stiff, count * stiff)
    matrix.flat[:: count * stiff + 1] += 1.0
    try:
        solved = np.linalg.solve(matrix, residual[:, :stiff].reshape(-1))
    except np.linalg.LinAlgError:
        return None
    correction = residual
    correction[:, :stiff] = solved.reshape(count, stiff)
    if stiff < width:
        moved = rule.integral @ correction[:, :stiff]
        correction[:, stiff:] += (derivative[:, stiff:] @ moved[:, :, None])[:, :, 0]
    return correction


def linearised(rates: Array, derivative: Array, lengths: Array) -> Array:
    """Rates, shape (n, d), at `lengths`, shape (n,), ahead of a place with `rates`, shape (d,), if
    their `derivative`, shape (d, k), by the first k components of the state stayed constant:
    exp(length J) f, a first guess that follows decaying components."""
    stiff = derivative.shape[1]
    values, vectors = np.linalg.eig(derivative[:stiff])
    try:
        weights = np.linalg.solve(vectors, rates[:stiff].astype(complex))
    except np.linalg.LinAlgError:
        return np.repeat(rates[None, :], lengths.size, axis=0)
    exponent = lengths[:, None] * values.real
    growth = np.exp(np.minimum(exponent, LARGEST_EXPONENT) + 1j * lengths[:, None] * values.imag)
    ahead = np.empty((lengths.size, rates.size))
    ahead[:, :stiff] = ((growth * weights) @ vectors.T).real
    with np.errstate(all="ignore"):
        integrals = np.where(values == 0.0, lengths[:, None], (growth - 1.0) / values)
    moved = ((integrals * weights) @ vectors.T).real
    ahead[:, stiff:] = rates[stiff:] + moved @ derivative[stiff:].T
    return ahead
