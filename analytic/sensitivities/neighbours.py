"""Neighbours of a problem, which differ in one parameter, and derivatives by that parameter.

With values g at the offsets x_k of the neighbours, the derivative at 0 is sum w_k g(x_k), where

    sum w_k x_k^m = 1 for m = 1, and 0 for m = 0 and 2 <= m < n                                 (1)

(Fornberg 1988, Math. Comp. 51, 699). With the n = 9 offsets -4 ... 4, the error is O(h^8); with the
inner seven offsets, O(h^6). The uncertainty is a multiple of the difference of the two results,
plus the rounding of g over h. If g has errors of its own, which differ from one neighbour to the
next, no polynomial explains them. Two combinations of the n values vanish for all polynomials of
degree n - 3. Their values, of all g together, show the size of such errors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array, Signals

CENTRAL_OFFSETS = (-4, -3, -2, -1, 0, 1, 2, 3, 4)
OFFSETS_ABOVE = (0, 1, 2, 3, 4, 5, 6, 7, 8)
OFFSETS_BELOW = tuple(-k for k in OFFSETS_ABOVE)
OFFSETS_LEFT_OUT = 2  # offsets that the stencil of lower order leaves out
# Ratio of the uncertainty to the difference of the two stencils. The difference also shows
# roundings of g that are larger than usual.
STENCIL_UNCERTAINTY_FACTOR = 4.0
# Ratio of the uncertainty to the standard deviation of errors of g. It is large because the
# deviation is estimated from few independent values: the errors at all times and of all observables
# are nearly equal.
DEVIATION_FACTOR = 8.0
# Quantile of the sizes of the errors of g at all times: at every time the size is at least that
USUAL_QUANTILE = 0.75
SIZE_OF_EXACT_ZERO = 1e-300  # size of the error of a value that is 0 and exact

Value = TypeVar("Value")
S = TypeVar("S")
Derived = tuple[Array, Array]
"""A derivative and its uncertainty, of the same shape."""


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of observables by one parameter at n times, and their uncertainty, shape (n,).

    If a derivative does not exist, it is NaN, and `why` has the reason. Then `below` and `above`
    hold the one-sided derivatives, for the parameter falling and rising, or NaN if these do not
    exist either. If every derivative exists, both are empty.
    """

    values: Signals
    uncertainty: Signals
    why: str = ""
    below: Signals = field(default_factory=dict)
    above: Signals = field(default_factory=dict)


@dataclass(frozen=True)
class Neighbours(Generic[Value]):
    """Results for a parameter at `offsets` from its value; the offset 0 is the value itself."""

    moved: tuple[Value, ...]
    offsets: Array

    @property
    def here(self) -> Value:
        """Result at the parameter's own value."""
        return self.moved[list(self.offsets).index(0.0)]

    def each(self, change: Callable[[Value], S]) -> Neighbours[S]:
        """Returns the neighbours with `change` applied to the result at every offset."""
        return Neighbours(tuple(change(result) for result in self.moved), self.offsets)

    @cached_property
    def _weights(self) -> tuple[Array, Array]:
        """The weights (eq. 1) of two stencils, shape (n,) each: of all offsets; and, of lower
        order, without the OFFSETS_LEFT_OUT farthest offsets, whose weights are 0."""
        nearest = np.argsort(np.abs(self.offsets), kind="stable")[
            : len(self.offsets) - OFFSETS_LEFT_OUT
        ]
        lower_order = np.zeros(len(self.offsets))
        lower_order[nearest] = _weights(self.offsets[nearest])
        return _weights(self.offsets), lower_order

    @cached_property
    def _unexplained(self) -> Array:
        """Orthonormal combinations of values that vanish for polynomials, shape (OFFSETS_LEFT_OUT,
        n)."""
        count = len(self.offsets) - OFFSETS_LEFT_OUT
        powers = np.vander(self.offsets / np.abs(self.offsets).max(), count, increasing=True)
        return np.asarray(np.linalg.svd(powers.T)[2][count:])

    def slope(self, read: Callable[[Value], float]) -> float:
        """Returns the derivative of the number that `read` gives, without its uncertainty."""
        values = np.array([read(result) for result in self.moved])
        weights, _ = self._weights
        return float(weights @ (values - values[self.offsets == 0.0]))

    def derivative(self, read: Callable[[Value], Any], errors: Array | None = None) -> Derived:
        """Returns the derivative of the array that `read` gives, and its uncertainty.

        The array has doubles or 34-digit numbers and any shape. If its values have errors of their
        own, `errors` has the relative sizes of these, with times along the last axis.
        """
        values = [np.asarray(read(result)) for result in self.moved]
        base = np.asarray(read(self.here))
        weights, lower_order = self._weights
        differences = np.array([double(value - base) for value in values])
        derivative = np.tensordot(weights, differences, 1)
        uncertainty = STENCIL_UNCERTAINTY_FACTOR * np.abs(
            derivative - np.tensordot(lower_order, differences, 1)
        )
        rounding = np.zeros(base.shape)
        if base.dtype == np.float64:  # the rounding of 34-digit numbers is negligible
            rounding = ULP * np.abs(values).max(axis=0)
            uncertainty += rounding * np.abs(weights).sum()
        if errors is not None:
            scale = errors + rounding + SIZE_OF_EXACT_ZERO
            ratio = self._unexplained_errors(differences, scale)
            uncertainty += DEVIATION_FACTOR * ratio * scale * np.linalg.norm(weights)
        return derivative, uncertainty

    def _unexplained_errors(self, differences: Array, scale: Array) -> Any:
        """Returns the standard deviation of the values' errors that no polynomial explains, over
        their `scale`, at each time, shape (n,). The `differences` of the values have the offsets
        along the first axis and the times along the last."""
        noise = np.tensordot(self._unexplained, differences, 1) / scale
        deviations = np.sqrt(np.mean(noise**2, axis=tuple(range(noise.ndim - 1))))
        # If the motion passes from one formula to another between neighbours, the deviation is
        # too large near that time alone.
        usual = 0.0
        if deviations.any():
            usual = np.quantile(deviations[deviations > 0.0], USUAL_QUANTILE)
        return np.maximum(usual, deviations)


def in_rows(observed: Signals, names: Sequence[str]) -> Array:
    """Returns the observables with these `names` as rows, shape (observables, n)."""
    return np.array([observed[name] for name in names])


def stacked(derived: Sequence[Derived]) -> Array:
    """Returns derivatives by several parameters along the last axis, followed by their
    uncertainties."""
    values, uncertainties = zip(*derived, strict=True)
    return np.stack([*values, *uncertainties], axis=-1)


def _weights(offsets: Array) -> Array:
    """Returns the weights of values at `offsets`, shape (n,), in their derivative at 0 (eq. 1)."""
    size = float(np.abs(offsets).max())
    powers = np.vander(offsets / size, increasing=True).T
    right = np.zeros(len(offsets))
    right[1] = 1.0 / size
    return np.asarray(np.linalg.solve(powers, right))
