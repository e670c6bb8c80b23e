"""Arithmetic with 34 digits, for the set-up of a reference, and for closed forms that lose digits.

Doubles have too few digits for a period that is multiplied by 10^10, or for an energy that misses a
barrier by a relative 10^-12. All functions are elementwise, for scalars and arrays alike. If
numpy-quaddtype is installed, it computes, because it is faster; else gmpy2 does. Both round each
result to 113 bits.
"""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np

Quad = Any
"""A 34-digit scalar, or an array of 34-digit numbers."""


def _arithmetic() -> ModuleType:
    """Returns the module of 34-digit numbers: numpy-quaddtype's if it is installed, else
    gmpy2's."""
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
    """Returns `value` if the condition holds, else `other`, elementwise."""
    if isinstance(condition, (bool, np.bool_)):
        return value if condition else other
    return np.where(condition, value, other)


def choose_lazily(condition: Any, value: Callable[[], Any], other: Callable[[], Any]) -> Any:
    """Returns the result of `value` if the condition holds, else the result of `other`,
    elementwise. A function whose result is chosen nowhere is not called."""
    if np.all(condition):
        return value()
    return choose(condition, value(), other()) if np.any(condition) else other()
