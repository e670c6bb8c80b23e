"""Arithmetic with 34 digits, for the set-up of a reference; its use over time stays in double.

A period that is used 10^10 times, or a barrier that an energy misses by 10^-12, needs more digits
than a double has. Everything here is elementwise: scalars and arrays alike.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy_quaddtype as quaddtype

from analytic.reference import Array

Quad = Any  # a QuadPrecision scalar or an array of dtype QuadPrecDType: one elementwise arithmetic
_DTYPE = quaddtype.QuadPrecDType()
PI: Quad = quaddtype.pi  # QuadPrecision(pi) would round it to double
EPSILON = 2.0**-112


def quad(value: Any) -> Quad:
    """Return numbers as 34-digit numbers of the same shape, exactly."""
    if isinstance(value, (int, float)):
        return quaddtype.QuadPrecision(value)
    return value if getattr(value, "dtype", None) == _DTYPE else np.asarray(value).astype(_DTYPE)


def double(value: Quad) -> Array:
    """Round 34-digit numbers to double."""
    return np.asarray(value).astype(np.float64)


def split(value: Quad, bits: int, parts: int) -> list[Array]:
    """Return doubles that add up to `value`: all but the last with at most `bits` leading bits,
    so that their products with integers below 2^(53 - bits) are exact."""
    pieces: list[Array] = []
    rest = value
    for _ in range(parts - 1):
        mantissa, exponent = np.frexp(double(rest))
        piece = np.ldexp(np.trunc(np.ldexp(mantissa, bits)), exponent - bits)
        pieces.append(piece)
        rest = rest - quad(piece)
    return [*pieces, double(rest)]


def select(conditions: list[Any], values: list[Quad]) -> Quad:
    """Return, elementwise, the value of the first condition that holds, else the last value."""
    result = values[-1]
    for condition, value in zip(reversed(conditions), reversed(values[:-1]), strict=True):
        if isinstance(condition, (bool, np.bool_)):
            result = value if condition else result
        else:
            result = np.where(condition, value, result)
    return result
