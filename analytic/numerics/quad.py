"""Arithmetic with 34 digits, for the set-up of a reference, and for closed forms that lose digits.

A period that is used 10^10 times, or a barrier that an energy misses by 10^-12, needs more digits
than a double has. Everything here is elementwise: scalars and arrays alike. numpy-quaddtype, which
is quicker, computes where it is installed, else gmpy2: both round each result to 113 bits.
"""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np

# a 34-digit scalar, or an array of them: one elementwise arithmetic
Quad = Any


def _arithmetic() -> ModuleType:
    """The module of 34-digit numbers: numpy-quaddtype's if it is installed, else gmpy2's."""
    try:
        from plumbob.analytic.numerics import quaddtype_numbers
    except ImportError:
        from plumbob.analytic.numerics import mpfr_numbers

        return mpfr_numbers
    return quaddtype_numbers


_CHOSEN = _arithmetic()
PI: Quad = _CHOSEN.PI
quad = _CHOSEN.quad
double = _CHOSEN.double


def choose(condition: Any, value: Any, other: Any) -> Any:
    """Return, elementwise, `value` where the condition holds, else `other`."""
    if isinstance(condition, (bool, np.bool_)):
        return value if condition else other
    return np.where(condition, value, other)


def chosen(condition: Any, value: Callable[[], Any], other: Callable[[], Any]) -> Any:
    """Return, elementwise, what `value` returns where the condition holds, else what `other` does;
    one that is chosen nowhere is not called."""
    if np.all(condition):
        return value()
    return choose(condition, value(), other()) if np.any(condition) else other()
