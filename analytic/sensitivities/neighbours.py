"""A problem with one parameter moved a little, and derivatives by that parameter.

With values g at the offsets x_k of the neighbours, the derivative at 0 is sum w_k g(x_k), where

    sum w_k x_k^m = 1 for m = 1, and 0 for m = 0 and 2 <= m < n                                 (1)

(Fornberg 1988, Math. Comp. 51, 699). Of n = 9 offsets -4 ... 4 the error is O(h^8), and of the
inner seven O(h^6): a multiple of their difference, with the rounding of g over h, is the
uncertainty. Where g has errors of its own, unlike from one neighbour to the next, their size shows
in what no polynomial of degree n - 3 explains: in the two combinations of n values that vanish for
all of these, of every g together.
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

CENTRAL = (-4, -3, -2, -1, 0, 1, 2, 3, 4)
ABOVE = (0, 1, 2, 3, 4, 5, 6, 7, 8)
BELOW = tuple(-k for k in ABOVE)
FEWER = 2  # offsets of the stencil of lower order
SURE = 4.0  # times the difference of the two, which shows roundings larger than one too
# Standard deviations of an error whose own size is known from few combinations, which time and
# observables have nearly in common.
DEVIATIONS = 8.0
USUAL = 0.75  # of the times have no larger ones
TINY = 1e-300  # where a value is 0 and exact

T = TypeVar("T")
S = TypeVar("S")
Derived = tuple[Array, Array]
"""A derivative and its uncertainty, of the same shape."""


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of observables by one parameter at n times, and their uncertainty, shape (n,).

    NaN where a derivative does not exist, with the reason in `why`; then `below` and `above` hold
    the one-sided derivatives, for the parameter falling and rising, NaN where these do not exist
    either. Both are empty where every derivative exists.
    """

    values: Signals
    uncertainty: Signals
    why: str = ""
    below: Signals = field(default_factory=dict)
    above: Signals = field(default_factory=dict)


@dataclass(frozen=True)
class Neighbours(Generic[T]):
    """All that a parameter's value determines, at `offsets` from it: `moved`, where the offset 0 is
    the value itself."""

    moved: tuple[T, ...]
    offsets: Array

    @property
    def here(self) -> T:
        """At the value itself."""
        return self.moved[list(self.offsets).index(0.0)]

    def each(self, change: Callable[[T], S]) -> Neighbours[S]:
        """The results of `change` at every offset."""
        return Neighbours(tuple(change(one) for one in self.moved), self.offsets)

    @cached_property
    def _weights(self) -> tuple[Array, Array]:
        """Those of eq. 1 and of the stencil of lower order, which has its nearest offsets."""
        nearest = np.argsort(np.abs(self.offsets), kind="stable")[: len(self.offsets) - FEWER]
        fewer = np.zeros(len(self.offsets))
        fewer[nearest] = _weights(self.offsets[nearest])
        return _weights(self.offsets), fewer

    @cached_property
    def _unexplained(self) -> Array:
        """Combinations of values that vanish for polynomials, orthonormal, shape (FEWER, n)."""
        count = len(self.offsets) - FEWER
        powers = np.vander(self.offsets / np.abs(self.offsets).max(), count, increasing=True)
        return np.asarray(np.linalg.svd(powers.T)[2][count:])

    def slope(self, read: Callable[[T], float]) -> float:
        """The derivative of a number alone."""
        values = np.array([read(one) for one in self.moved])
        return float(self._weights[0] @ (values - values[self.offsets == 0.0]))

    def derivative(self, read: Callable[[T], Any], errors: Array | None = None) -> Derived:
        """The derivative of what `read` gives, of doubles or of 34 digits, of any shape; `errors`
        are what its own are proportional to, from one value to another, with times in the last
        axis."""
        values = [np.asarray(read(one)) for one in self.moved]
        base = np.asarray(read(self.here))
        all_of_them, fewer = self._weights
        differences = np.array([double(value - base) for value in values])
        found = np.tensordot(all_of_them, differences, 1)
        uncertain = SURE * np.abs(found - np.tensordot(fewer, differences, 1))
        rounded = np.zeros(base.shape)
        if base.dtype == np.float64:  # in 34 digits nothing is left of a rounding
            rounded = ULP * np.abs(values).max(axis=0)
            uncertain += rounded * np.abs(all_of_them).sum()
        if errors is not None:
            size = errors + rounded + TINY
            left = np.tensordot(self._unexplained, differences, 1) / size
            sizes = np.sqrt(np.mean(left**2, axis=tuple(range(left.ndim - 1))))
            # A formula that changes in between shows at its time alone.
            usual = np.quantile(sizes[sizes > 0.0], USUAL) if sizes.any() else 0.0
            ratio = np.maximum(usual, sizes)
            uncertain += DEVIATIONS * ratio * size * np.linalg.norm(all_of_them)
        return found, uncertain


def in_rows(observed: Signals, names: Sequence[str]) -> Array:
    """The observables of these names, shape (observables, n)."""
    return np.array([observed[name] for name in names])


def stacked(derived: Sequence[Derived]) -> Array:
    """Derivatives by several parameters in the last axis, then all their uncertainties."""
    values, uncertain = zip(*derived, strict=True)
    return np.stack([*values, *uncertain], axis=-1)


def _weights(offsets: Array) -> Array:
    """Weights of the values at `offsets`, shape (n,), in their derivative at 0 (eq. 1)."""
    size = float(np.abs(offsets).max())
    powers = np.vander(offsets / size, increasing=True).T
    right = np.zeros(len(offsets))
    right[1] = 1.0 / size
    return np.asarray(np.linalg.solve(powers, right))
