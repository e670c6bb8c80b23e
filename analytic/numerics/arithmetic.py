"""Round-off of doubles: its size, and what it makes of a formula."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array

ROUNDOFF = 2.0**-53  # unit round-off: largest relative error of one rounding
ULP = 2.0**-52  # machine epsilon: distance from 1 to the next double

NEAR = 1e-7  # relative change of a parameter, by which the effect of its rounding is known


def rounded_inputs(
    problem: Any, observe: Callable[[Any], Mapping[str, Array]], roundings: float
) -> dict[str, Array]:
    """Changes of what is observed by so many roundings of each number of a `problem`, a dataclass,
    and by its own rounding."""
    exact = observe(problem)
    doubts = {name: ULP * np.abs(values) for name, values in exact.items()}
    for field in fields(problem):
        if isinstance(value := getattr(problem, field.name), float):
            moved = observe(replace(problem, **{field.name: value * (1.0 - NEAR)}))
            for name, values in exact.items():
                doubts[name] += roundings * ULP / NEAR * np.abs(moved[name] - values)
    return doubts
