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


def varied(inputs: Any, fraction: float) -> Iterator[Any]:
    """Yields copies of a dataclass or array, the `inputs`, each with one number reduced by a
    `fraction` of its value. Every number except zeros is reduced in turn."""
    if is_dataclass(inputs) and not isinstance(inputs, type):
        for field in fields(inputs):
            for reduced in varied(getattr(inputs, field.name), fraction):
                yield replace(inputs, **{field.name: reduced})
    elif getattr(inputs, "ndim", 0):  # an array of doubles or of 34 digits
        for i in np.flatnonzero(inputs != 0.0):
            reduced = inputs.copy()
            reduced[i] = inputs[i] * (1.0 - fraction)
            yield reduced
    elif isinstance(inputs, float) and inputs:
        yield inputs * (1.0 - fraction)


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
