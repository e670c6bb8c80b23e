"""Arithmetic with 34 digits, for the set-up of a reference, and for closed forms that lose digits.

A period that is used 10^10 times, or a barrier that an energy misses by 10^-12, needs more digits
than a double has. Everything here is elementwise: scalars and arrays alike.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy_quaddtype as quaddtype

# a QuadPrecision scalar or an array of dtype QuadPrecDType: one elementwise arithmetic
Quad = Any
_DTYPE = quaddtype.QuadPrecDType()
PI: Quad = quaddtype.pi  # QuadPrecision(pi) would round it to double


def quad(value: Any) -> Quad:
    """Return numbers as 34-digit numbers of the same shape, exactly; of no shape as scalars, whose
    arithmetic costs a fifth of an array's."""
    if isinstance(value, quaddtype.QuadPrecision):
        return value
    if isinstance(value, (float, int)):
        return quaddtype.QuadPrecision(value)
    array = np.asarray(value)
    array = array if array.dtype == _DTYPE else array.astype(_DTYPE)
    return array if array.ndim else array[()]


def double(value: Quad) -> Any:
    """Round 34-digit numbers to double: a scalar to a float, an array to an array."""
    if isinstance(value, (float, quaddtype.QuadPrecision)):
        return float(value)
    return np.asarray(value).astype(np.float64)


def choose(condition: Any, value: Any, other: Any) -> Any:
    """Return, elementwise, `value` where the condition holds, else `other`."""
    if isinstance(condition, (bool, np.bool_)):
        return value if condition else other
    return np.where(condition, value, other)
