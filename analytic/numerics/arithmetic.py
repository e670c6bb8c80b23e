"""Round-off of doubles: its size, and sums and products that keep their rounding errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from plumbob.analytic.reference import Array

ROUNDOFF = 2.0**-53  # unit round-off: largest relative error of one rounding
ULP = 2.0**-52  # machine epsilon: distance from 1 to the next double

Number = TypeVar("Number", float, Array)

NEAR = 1e-7  # relative change of a parameter, by which the effect of its rounding is known
SPLITTER = 134217729.0  # 2^27 + 1 halves the 53 bits of a double


def two_sum(a: Number, b: Number) -> tuple[Number, Number]:
    """Return the rounded sum of `a` and `b` and its rounding error, exactly (Knuth 1969, The Art of
    Computer Programming 2, 4.2.2, theorem B)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def two_product(a: Number, b: Number) -> tuple[Number, Number]:
    """Return the rounded product of `a` and `b` and its rounding error, exactly (Dekker 1971,
    Numer. Math. 18, 224); magnitudes below 1e150.

    >>> two_product(0.1, 10.0)
    (1.0, 5.551115123125783e-17)
    """
    a_high, a_low = _halves(a)
    b_high, b_low = _halves(b)
    product = a * b
    return product, a_low * b_low - (product - a_high * b_high - a_low * b_high - a_high * b_low)


def _halves(a: Number) -> tuple[Number, Number]:
    """Two parts of at most 26 bits that add up to `a` exactly."""
    shifted = SPLITTER * a
    high = shifted - (shifted - a)
    return high, a - high


def rounded_inputs(
    problem: Any, observe: Callable[[Any], Mapping[str, Array]], roundings: float
) -> dict[str, Array]:
    """What so many roundings of each number of a `problem`, a dataclass, make of what is observed
    of it, and one of that itself."""
    exact = observe(problem)
    doubts = {name: ULP * np.abs(values) for name, values in exact.items()}
    for field in fields(problem):
        if isinstance(value := getattr(problem, field.name), float):
            moved = observe(replace(problem, **{field.name: value * (1.0 - NEAR)}))
            for name, values in exact.items():
                doubts[name] += roundings * ULP / NEAR * np.abs(moved[name] - values)
    return doubts
