"""Radau collocation of high order on one element: the implicit step behind every smooth segment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre
from scipy.special import roots_jacobi

from plumbob.analytic.reference import Array

ITERATIONS = 12
CONVERGED = 1e-15  # Newton step over the state's scale
STALLED = 1e-12  # below this a step that no longer shrinks is round-off
DIVERGED = 1e6

RightHandSide = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Scheme:
    """Radau IIA with n nodes on (0, 1], the last at 1: order 2n - 1, stiffly accurate.

    `integrals` [i, j] integrates the j-th cardinal polynomial from 0 to node i; `slopes` [i, j] is
    its derivative at node i; `spectrum` turns
    values at the nodes into Legendre coefficients; `antiderivative` turns those into the
    coefficients of the integral from 0.
    """

    nodes: Array
    integrals: Array
    slopes: Array
    spectrum: Array
    antiderivative: Array


@lru_cache(maxsize=8)
def scheme(count: int) -> Scheme:
    """The Scheme with `count` nodes (Hairer and Wanner 1996, section IV.5)."""
    inner = np.asarray(roots_jacobi(count - 1, 1.0, 0.0)[0])
    x = np.append(inner, 1.0)
    basis = legendre.legvander(x, count - 1)
    spectrum = np.linalg.inv(basis)
    antiderivative: Array = np.asarray(0.5 * legendre.legint(np.eye(count), lbnd=-1.0))
    integrals = legendre.legvander(x, count) @ antiderivative @ spectrum
    slopes = 2.0 * legendre.legvander(x, count - 2) @ legendre.legder(spectrum)
    return Scheme(0.5 * (x + 1.0), integrals, np.asarray(slopes), spectrum, antiderivative)


def evaluate(coefficients: Array, places: Array) -> Array:
    """Polynomials with Legendre `coefficients`, shape (k, d), at `places` in [0, 1], shape (n,):
    shape (n, d)."""
    return np.asarray(legendre.legval(2.0 * places - 1.0, coefficients, tensor=True).T)


def primitive(rule: Scheme, start: Array, slopes: Array) -> Array:
    """Legendre coefficients, shape (n + 1, d), of start + integral of the polynomial through
    `slopes`, shape (n, d), at the nodes."""
    coefficients = rule.antiderivative @ (rule.spectrum @ slopes)
    coefficients[0] += start
    return np.asarray(coefficients)


def collocate(
    rule: Scheme, right_hand_side: RightHandSide, start: Array, guess: Array, scale: Array
) -> Array | None:
    """Slopes dz/dc at the nodes, shape (n, d), of the polynomial that solves dz/dc = f(z) there, or
    None if Newton's iteration does not converge.

    `right_hand_side` maps states (n, d) to slopes (n, d) and their derivatives (n, d, k) by the
    first k parts of the state; the others may enter f weakly. `start` [d] is the state at c = 0;
    `guess` the first slopes; `scale` [d] the size of the state.
    """
    count, width = guess.shape
    slopes, previous = guess.copy(), 0.0
    coupling: Array | None = None
    for _ in range(ITERATIONS):
        value, derivative = right_hand_side(start + rule.integrals @ slopes)
        stiff = derivative.shape[2]
        if not np.isfinite(derivative.sum() + value.sum()):
            return None
        if coupling is None:
            coupling = np.empty((count, stiff, count, stiff))
        np.multiply(-rule.integrals[:, None, :, None], derivative[:, :stiff, None, :], out=coupling)
        matrix = coupling.reshape(count * stiff, count * stiff)
        matrix.flat[:: count * stiff + 1] += 1.0
        residual = value - slopes
        try:
            solved = np.linalg.solve(matrix, residual[:, :stiff].reshape(-1))
        except np.linalg.LinAlgError:
            return None
        correction = residual
        correction[:, :stiff] = solved.reshape(count, stiff)
        if stiff < width:
            moved = rule.integrals @ correction[:, :stiff]
            correction[:, stiff:] += (derivative[:, stiff:] @ moved[:, :, None])[:, :, 0]
        slopes += correction
        step = float((np.abs(rule.integrals @ correction) / scale).max())
        # Newton's steps shrink ever faster: the next one is below step^2/previous.
        if step <= CONVERGED or step * step <= CONVERGED * previous or STALLED > step > previous:
            return slopes
        if step > DIVERGED:
            return None
        previous = step
    return None


def tail(rule: Scheme, slopes: Array, scale: Array) -> float:
    """Size over `scale` of the last Legendre coefficients of the solution with these `slopes`: what
    a polynomial of this degree leaves out."""
    last = np.abs(rule.spectrum[-3:] @ slopes).max(axis=0)
    return float(np.max(last / scale) / len(slopes))


def linearised(rates: Array, derivative: Array, lengths: Array) -> Array:
    """Rates at `lengths` (n,) ahead if `derivative` (d, k) by the first k parts of the state stayed
    as it is: exp(length J) f, shape (n, d), a first guess that knows what decays."""
    stiff = derivative.shape[1]
    values, vectors = np.linalg.eig(derivative[:stiff])
    try:
        shares = np.linalg.solve(vectors, rates[:stiff].astype(complex))
    except np.linalg.LinAlgError:
        return np.repeat(rates[None, :], lengths.size, axis=0)
    growth = np.exp(
        np.minimum(lengths[:, None] * values.real, 3.0) + 1j * lengths[:, None] * values.imag
    )
    ahead = np.empty((lengths.size, rates.size))
    ahead[:, :stiff] = ((growth * shares) @ vectors.T).real
    with np.errstate(all="ignore"):
        integrals = np.where(values == 0.0, lengths[:, None], (growth - 1.0) / values)
    moved = ((integrals * shares) @ vectors.T).real
    ahead[:, stiff:] = rates[stiff:] + moved @ derivative[stiff:].T
    return ahead
