"""Round-off of doubles: its size, and its effect on the results of a formula."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals

ROUNDOFF = 2.0**-53  # unit round-off: largest relative error of one rounding
ULP = 2.0**-52  # machine epsilon: distance from 1 to the next double

# relative change of a parameter that measures the effect of its rounding
PARAMETER_CHANGE = 1e-7


def _elementwise(of_number: Any, of_array: Any) -> Any:
    """Returns a function that calls `of_number` for a float, in a fifth of the time, and numpy's
    `of_array` for anything else."""
    return lambda x: of_number(x) if isinstance(x, float) else of_array(x)


sin = _elementwise(math.sin, np.sin)
cos = _elementwise(math.cos, np.cos)
sqrt = _elementwise(math.sqrt, np.sqrt)


def varied(given: Any, part: float) -> Iterator[Any]:
    """Yields copies of a dataclass or array `given`, each with one number reduced by the fraction
    `part`. Every number except zeros is reduced in turn."""
    if is_dataclass(given) and not isinstance(given, type):
        for field in fields(given):
            for reduced in varied(getattr(given, field.name), part):
                yield replace(given, **{field.name: reduced})
    elif getattr(given, "ndim", 0):  # an array of doubles or of 34 digits
        for i in np.flatnonzero(given != 0.0):
            reduced = given.copy()
            reduced[i] = given[i] * (1.0 - part)
            yield reduced
    elif isinstance(given, float) and given:
        yield given * (1.0 - part)


def rounded_inputs(
    problem: Any, observe: Callable[[Any], Signals], roundings: float
) -> dict[str, Array]:
    """Returns the effect of rounding on each observable of a `problem`, a dataclass.

    Each number of the problem is rounded by as many units in the last place as `roundings` says,
    and the observable itself by one. The absolute effects are summed.
    """
    exact = observe(problem)
    doubts = {name: ULP * np.abs(values) for name, values in exact.items()}
    for neighbour in varied(problem, PARAMETER_CHANGE):
        for name, values in observe(neighbour).items():
            doubts[name] += roundings * ULP / PARAMETER_CHANGE * np.abs(values - exact[name])
    return doubts
