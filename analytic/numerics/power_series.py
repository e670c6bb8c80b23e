"""Truncated power series, which can be passed to formulas that are written for numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from operator import add, neg, sub
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin


class Series(NDArrayOperatorsMixin):
    """A truncated power series in one variable.

    `terms`, from degree 0 on, are numbers or arrays whose shapes broadcast. The operations are + -
    * /, sine and cosine. The other operand may be a series, or a number or an array, which counts
    as a constant. If two series have different degrees, the result has the lower degree.
    """

    def __init__(self, terms: Sequence[Any]) -> None:
        self.terms = list(terms)

    def __array_ufunc__(self, function: Any, method: str, *values: Any, **options: Any) -> Any:
        if method != "__call__" or options or function.__name__ not in _RULES:
            return NotImplemented
        count = min(len(value.terms) for value in values if isinstance(value, Series))
        operands = [_terms(value, count) for value in values]
        return Series(_RULES[function.__name__](*operands))


def variable(degree: int) -> Series:
    """Returns the variable itself as a series of a `degree`, 1 or more."""
    return Series([0.0, 1.0] + (degree - 1) * [0.0])


def constant(value: Any, degree: int) -> Series:
    """Returns the series of a constant, a number or an array."""
    return Series(_terms(value, degree + 1))


def flow_series(
    slope: Callable[[Any, Sequence[Any]], Sequence[Any]], start: Sequence[Series]
) -> list[Series]:
    """Returns the solution z(h) of z' = `slope`(h, z) as power series in h.

    `start` has one series for each part of z, whose constants are z(0). The terms are computed from
    the lowest degree up.
    """
    state = [Series(part.terms) for part in start]
    for n in range(1, len(state[0].terms)):
        rates = slope(variable(n - 1), [Series(part.terms[:n]) for part in state])
        for part, rate in zip(state, rates, strict=True):
            part.terms[n] = part.terms[n] + rate.terms[n - 1] / n
    return state


def _terms(value: Any, count: int) -> list[Any]:
    """Returns the first `count` terms of a series or of a constant."""
    if isinstance(value, Series):
        return value.terms[:count]
    return [value] + (count - 1) * [0.0]


def _is_zero(term: Any) -> bool:
    """Returns whether a term is a zero number; an array of zeros counts as not zero."""
    return isinstance(term, float) and term == 0.0


def _product(a: list[Any], b: list[Any]) -> list[Any]:
    """Returns the terms of the product of two series with as many terms."""
    terms: list[Any] = [0.0] * len(a)
    for i, x in enumerate(a):
        if not _is_zero(x):
            for j, y in enumerate(b[: len(a) - i]):
                if not _is_zero(y):
                    terms[i + j] = terms[i + j] + x * y
    return terms


def _quotient(a: list[Any], b: list[Any]) -> list[Any]:
    """Returns the terms of the quotient of two series with as many terms."""
    terms: list[Any] = []
    for n, x in enumerate(a):
        lower_terms = sum(b[i] * terms[n - i] for i in range(1, n + 1))
        terms.append((x - lower_terms) / b[0])
    return terms


def _sine_cosine(a: list[Any]) -> tuple[list[Any], list[Any]]:
    """Returns the terms of the sine and the cosine of a series, from (sin u)' = u' cos u and
    (cos u)' = -u' sin u."""
    sine = [np.sin(a[0])]
    cosine = [np.cos(a[0])]
    for n in range(1, len(a)):
        sine_term = cosine_term = 0.0
        for i in range(1, n + 1):
            if not _is_zero(a[i]):
                derivative = i / n * a[i]
                sine_term = sine_term + derivative * cosine[n - i]
                cosine_term = cosine_term + derivative * sine[n - i]
        sine.append(sine_term)
        cosine.append(-cosine_term)
    return sine, cosine


_RULES: Mapping[str, Callable[..., list[Any]]] = MappingProxyType(
    {
        "add": lambda *pair: list(map(add, *pair)),
        "subtract": lambda *pair: list(map(sub, *pair)),
        "multiply": _product,
        "divide": _quotient,
        "negative": lambda a: list(map(neg, a)),
        "sin": lambda a: _sine_cosine(a)[0],
        "cos": lambda a: _sine_cosine(a)[1],
    }
)
