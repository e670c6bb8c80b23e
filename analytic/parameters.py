"""Checks on parameters: what breaks is said by name, with its value and what it must be."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any


class ParameterError(ValueError):
    """A parameter outside what the equations allow; its text is one line."""

    def __init__(self, name: str, value: object, requirement: str) -> None:
        super().__init__(f"{name} = {value!r}: must be {requirement}")
        self.name, self.value, self.requirement = name, value, requirement


def finite(name: str, value: Any) -> float:
    """Return `value` as a finite float, or raise ParameterError naming it."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ParameterError(name, value, "a finite number")
    return float(value)


def positive(name: str, value: Any) -> float:
    """Return `value` as a finite float above zero, or raise ParameterError naming it."""
    if (number := finite(name, value)) <= 0.0:
        raise ParameterError(name, value, "greater than 0")
    return number


def non_negative(name: str, value: Any) -> float:
    """Return `value` as a finite float of zero or more, or raise ParameterError naming it."""
    if (number := finite(name, value)) < 0.0:
        raise ParameterError(name, value, "0 or greater")
    return number


def known(given: Mapping[str, Any], names: Iterable[str]) -> None:
    """Raise ParameterError for the first name in `given` that is not one of `names`."""
    allowed = sorted(names)
    for name, value in given.items():
        if name not in allowed:
            raise ParameterError(name, value, f"one of the names {', '.join(allowed)}")
