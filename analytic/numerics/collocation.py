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

ITERATIONS = 12
CONVERGED = 1e-15  # Newton step over the scale of the state
STALLED = 1e-12  # below this a step that no longer shrinks is round-off
DIVERGED = 1e6  # Newton step over the scale of the state
FACTORED = 1e-4  # Newton step over the scale of the state, below which its matrix is used again
SLOW = 0.1  # of the step before: such a step with an old matrix requires a new one
LARGEST_EXPONENT = 3.0  # a first guess needs no faster growth than this

RightHandSide = Callable[[Array, bool], tuple[Array, Array]]
"""States at the nodes, and whether derivatives are wanted -> slopes there, and these."""


@dataclass(frozen=True)
class TimeGrid:
    """The steps that a motion from time 0 on was computed in."""

    breakpoints: Array  # [s], shape (steps + 1,)

    @property
    def duration(self) -> float:
        """Time of the last breakpoint [s]."""
        return float(self.breakpoints[-1])

    def locate(self, times: Array) -> npt.NDArray[np.intp]:
        """Index of the step that each of `times` [s] falls in. Raises ParameterError."""
        times = np.asarray(times, dtype=float)
        if times.size and not (times.min() >= 0.0 and times.max() <= self.duration):
            worst = times.min() if not times.min() >= 0.0 else times.max()
            raise ParameterError("times", float(worst), f"between 0 and {self.duration} s")
        last = len(self.breakpoints) - 2
        return np.minimum(np.searchsorted(self.breakpoints, times, side="right") - 1, last)


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
        return basis(fractions, len(self.nodes) + 1) @ self.antiderivative @ self.spectrum

    def primitive(self, start: Array, slopes: Array) -> Array:
        """Legendre coefficients, shape (n + 1, d), of `start`, shape (d,), plus the integral of the
        polynomial through `slopes`, shape (n, d), at the nodes."""
        coefficients = self.antiderivative @ (self.spectrum @ slopes)
        coefficients[0] += start
        return coefficients

    def shortened(self, slopes: Array, part: float) -> Array:
        """The slopes of the polynomial with `slopes`, shape (n, d), at the nodes, where only the
        first `part` of its interval becomes the interval."""
        return part * basis(part * self.nodes, len(slopes)) @ (self.spectrum @ slopes)

    def truncation(self, slopes: Array, scale: Array) -> float:
        """Truncation error of the solution with `slopes`, shape (n, d), over its `scale`, shape
        (d,): the size of its last three Legendre coefficients."""
        last = np.abs(self.spectrum[-3:] @ slopes).max(axis=0)
        return float(np.max(last / scale) / len(slopes))


@lru_cache(maxsize=4)
def gauss_collocation(stages: int) -> Collocation:
    """The Gauss-Legendre rule of `stages` nodes; its collocation method has order 2 stages
    (Hairer, Lubich and Wanner 2006, Geometric Numerical Integration, II.1)."""
    return _collocation(legendre.leggauss(stages)[0])


@lru_cache(maxsize=8)
def radau_collocation(stages: int) -> Collocation:
    """The Radau IIA rule of `stages` nodes, the last at 1: order 2 stages - 1 and stiffly accurate
    (Hairer and Wanner 1996, Solving Ordinary Differential Equations II, IV.5)."""
    from scipy.special import roots_jacobi

    return _collocation(np.append(np.asarray(roots_jacobi(stages - 1, 1.0, 0.0)[0]), 1.0))


def _collocation(points: Array) -> Collocation:
    """The rule of nodes at `points` of (-1, 1], shape (n,)."""
    stages = len(points)
    nodes = (points + 1.0) / 2.0
    spectrum = np.linalg.inv(
        np.asarray(legendre.legvander(points, stages - 1), dtype=np.float64)
    )
    slopes = 2.0 * legendre.legvander(points, stages - 2) @ legendre.legder(spectrum)
    # Legendre coefficients of the integrals from 0 of the shifted Legendre polynomials
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
    """Values, shape (n, count), of the first `count` shifted Legendre polynomials at `places` in
    [0, 1], shape (n,)."""
    return np.asarray(legendre.legvander(2.0 * places - 1.0, count - 1), dtype=np.float64)


def evaluate(coefficients: Array, places: Array) -> Array:
    """Values, shape (n, d), at `places` in [0, 1], shape (n,), of polynomials with Legendre
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
    """Slopes dz/dc at the nodes, shape (n, d), of the polynomial that solves dz/dc = f(z) there, or
    None if Newton's iteration does not converge.

    `right_hand_side` maps states (n, d) to slopes (n, d) and, if asked, their derivatives (n, d, k)
    by the first k components of the state; f may depend weakly on the others, or in other ways on
    the first k: then `all_derivatives` is False. `start` (d,) is the state at c = 0, `guess` (n, d)
    the first slopes, `scale` (d,) the size of the state.
    """
    slopes = guess.copy()
    previous = 0.0
    last = False
    newton = None
    for _ in range(ITERATIONS):
        fresh = newton is None
        value, derivative = right_hand_side(start + rule.integral @ slopes, fresh)
        if fresh:
            newton = _newton(rule, derivative)
        if newton is None or not np.isfinite(value.sum()):
            return None
        correction = newton(value - slopes)
        slopes += correction
        step = float((np.abs(rule.integral @ correction) / scale).max())
        # Newton's method converges quadratically, with an old matrix linearly: the next step is
        # below step^2/previous. Where derivatives are left out, that step is taken all the same: a
        # small part of the error converges more slowly than the steps until then.
        ends = step * step <= CONVERGED * previous
        if step <= CONVERGED or STALLED > step > previous or last or (ends and all_derivatives):
            return slopes
        last = ends
        if step > DIVERGED:
            return None
        if step > FACTORED or (not fresh and step > SLOW * previous):
            newton = None
        previous = step
    return None


def _newton(rule: Collocation, derivative: Array) -> Callable[[Array], Array] | None:
    """Newton's correction of the slopes, shape (n, d), for their residual, which it replaces: by
    the derivatives at the nodes, shape (n, d, k), implicit in the first k components and then
    explicit in the others; None where its matrix is singular, or they are not finite."""
    from scipy.linalg.lapack import dgetrf, dgetrs

    if not np.isfinite(derivative.sum()):
        return None
    count, _, stiff = derivative.shape
    across = derivative[:, :stiff].transpose(2, 0, 1)
    others = derivative[:, stiff:]
    matrix = np.multiply(-rule.integral.T[:, None, :, None], across[None]).reshape(-1)
    matrix[:: count * stiff + 1] += 1.0
    square = matrix.reshape(count * stiff, count * stiff).T
    factors, pivots, singular = dgetrf(square, overwrite_a=True)

    def correction(residual: Array) -> Array:
        # one column, which LAPACK takes as a vector
        right: Any = residual[:, :stiff].reshape(-1)
        residual[:, :stiff] = dgetrs(factors, pivots, right)[0].reshape(-1, stiff)
        if stiff < residual.shape[1]:
            moved = rule.integral @ residual[:, :stiff]
            residual[:, stiff:] += (others @ moved[:, :, None])[:, :, 0]
        return residual

    return None if singular else correction


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
    growth = np.exp(
        np.minimum(exponent, LARGEST_EXPONENT) + 1j * lengths[:, None] * values.imag
    )
    ahead = np.empty((lengths.size, rates.size))
    ahead[:, :stiff] = ((growth * weights) @ vectors.T).real
    with np.errstate(all="ignore"):
        integrals = np.where(values == 0.0, lengths[:, None], (growth - 1.0) / values)
    moved = ((integrals * weights) @ vectors.T).real
    ahead[:, stiff:] = rates[stiff:] + moved @ derivative[stiff:].T
    return ahead
