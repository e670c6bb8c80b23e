"""34-digit numbers by numpy-quaddtype, which is faster than gmpy2 but has fewer wheels."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy_quaddtype as quaddtype

_DTYPE = quaddtype.QuadPrecDType()
PI: Any = quaddtype.pi  # QuadPrecision(pi) would round it to double


def quad(value: Any) -> Any:
    """Returns numbers as 34-digit numbers of the same shape, exactly.

    A number without a shape becomes a scalar: arithmetic with a scalar takes a fifth of the time.
    """
    if isinstance(value, quaddtype.QuadPrecision):
        return value
    if isinstance(value, (float, int)):
        return quaddtype.QuadPrecision(value)
    array = np.asarray(value)
    array = array if array.dtype == _DTYPE else array.astype(_DTYPE)
    return array if array.ndim else array[()]


def double(value: Any) -> Any:
    """Returns 34-digit numbers rounded to double: a float for a scalar, else an array."""
    if isinstance(value, (float, quaddtype.QuadPrecision)):
        return float(value)
    return np.asarray(value).astype(np.float64)
