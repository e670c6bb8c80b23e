"""An axis of a drawing: places of values, and ticks at round ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Axis:
    """Where values lie between two ends of a picture."""

    low: float
    high: float
    start: float
    end: float
    logarithmic: bool

    def at(self, value: float) -> float:
        """The place of a value."""
        return float(self.along([value])[0])

    def along(self, values: Sequence[float | None] | Array) -> Array:
        """Places of values; NaN where one has none."""
        numbers = np.asarray(values, dtype=float)
        if self.logarithmic:
            nowhere = np.full_like(numbers, np.nan)
            numbers = np.log10(numbers, out=nowhere, where=numbers > 0.0)
        part = (numbers - self.low) / (self.high - self.low)
        return self.start + part * (self.end - self.start)

    def ticks(self, most: int) -> list[tuple[float, str]]:
        """Places of a few round values, and the values as text."""
        ends, values = (self.low, self.high), list[float]()
        if self.logarithmic:
            first, last = math.ceil(self.low - 1e-9), math.floor(self.high + 1e-9)
            powers = range(first, last + 1, max(1, -(-(last - first + 1) // most)))
            if len(powers) > 1:
                return [(self.at(10.0**p), f"10{str(p).translate(SUPERSCRIPTS)}") for p in powers]
            values = [k * 10.0**p for p in range(first - 1, last + 1) for k in (1, 2, 5)]
            values = [v for v in values if self.low <= math.log10(v) <= self.high]
            ends = 10.0**self.low, 10.0**self.high
        if len(values) < 2:
            low, high = ends
            unit = 10.0 ** math.floor(math.log10((high - low) / most))
            step = next(unit * k for k in (1, 2, 5, 10) if high - low <= most * unit * k)
            values = [step * k for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
        return [(self.at(v), f"{v:g}") for v in values]
