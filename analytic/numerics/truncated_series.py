"""Arithmetic of power series in the step, cut off at one degree: axis 0 is the degree."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array

Series = TypeVar("Series", npt.NDArray[np.float64], npt.NDArray[np.complex128])


def constant(values: Array, degree: int) -> Array:
    """Series of the given degree whose only term is `values`, any shape."""
    series = np.zeros((degree + 1, *np.shape(values)))
    series[0] = values
    return series


def raised(series: Series, power: int = 1) -> Series:
    """The series times the variable to `power`."""
    higher = np.zeros_like(series)
    higher[power:] = series[: len(series) - power]
    return higher


def moved(series: Series, slope: Series, multiple: float, divisor: float) -> Series:
    """The series and a multiple of the variable times another, as a `Tableau` takes stages."""
    return series + multiple * raised(slope) / divisor


def over_one_plus(series: Array, linear: float, square: float) -> Array:
    """The series divided by 1 + linear h + square h^2, h its variable."""
    quotient = series.copy()
    for n in range(1, len(series)):
        quotient[n] -= linear * quotient[n - 1] + (square * quotient[n - 2] if n > 1 else 0.0)
    return quotient


def sine_cosine(series: Array) -> tuple[Array, Array]:
    """Series of the sine and the cosine of a series, by (sin u)' = u' cos u and its like."""
    sine, cosine = np.zeros_like(series), np.zeros_like(series)
    sine[0], cosine[0] = np.sin(series[0]), np.cos(series[0])
    for n in range(1, len(series)):
        for i in range(1, n + 1):
            sine[n] += i / n * series[i] * cosine[n - i]
            cosine[n] -= i / n * series[i] * sine[n - i]
    return sine, cosine


def product(first: Series, second: Series) -> Series:
    """Product of two series of the same degree."""
    total = np.zeros_like(first)
    for n in range(len(first)):
        for i in range(n + 1):
            total[n] += first[i] * second[n - i]
    return total
