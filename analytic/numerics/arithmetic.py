"""Double precision: its unit of rounding, and error-free sums and products of doubles."""

from __future__ import annotations

from typing import TypeVar

from plumbob.analytic.reference import Array

Number = TypeVar("Number", float, Array)

ULP = 2.0**-52  # spacing of the doubles next to 1: a unit in the last place, relatively
ROUNDOFF = 2.0**-53  # largest relative error of one rounding
SPLITTER = 134217729.0  # 2^27 + 1 halves the 53 bits of a double


def two_sum(a: Number, b: Number) -> tuple[Number, Number]:
    """Return the rounded sum of `a` and `b` and its rounding error, exactly (Knuth 1969)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def two_product(a: Number, b: Number) -> tuple[Number, Number]:
    """Return the rounded product of `a` and `b` and its rounding error, exactly (Dekker 1971);
    magnitudes below 1e150."""
    a_high, a_low = _halves(a)
    b_high, b_low = _halves(b)
    product = a * b
    return product, a_low * b_low - (product - a_high * b_high - a_low * b_high - a_high * b_low)


def _halves(a: Number) -> tuple[Number, Number]:
    shifted = SPLITTER * a
    high = shifted - (shifted - a)
    return high, a - high
