"""An axis of a drawing: pixel positions of values, and ticks at round values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
Ticks = Sequence[tuple[float, str]]
"""(position [px], text) of each tick."""


def power_of_ten(power: int) -> str:
    """Returns a power of ten as text: 10⁻³."""
    return f"10{str(power).translate(SUPERSCRIPTS)}"


@dataclass(frozen=True)
class Axis:
    """A linear or logarithmic axis that maps the values from `low` to `high` to the pixels from
    `start` to `end`. If the axis is logarithmic, `low` and `high` are exponents of ten."""

    low: float
    high: float
    start: float
    end: float
    logarithmic: bool

    @property
    def scale(self) -> float:
        """Units per pixel; negative if the pixel positions fall as the values rise."""
        return (self.high - self.low) / (self.end - self.start)

    def scaled(self, scale: float) -> Axis:
        """Returns an axis with the same middle and pixels, and `scale` units per pixel."""
        middle = (self.low + self.high) / 2
        half = abs(self.end - self.start) * scale / 2
        return replace(self, low=middle - half, high=middle + half)

    def along(self, values: npt.ArrayLike) -> Array:
        """Returns the positions of values [px]; NaN for a value that has no logarithm."""
        numbers = np.asarray(values, dtype=float)
        if self.logarithmic:
            all_nan = np.full_like(numbers, np.nan)
            numbers = np.log10(numbers, out=all_nan, where=numbers > 0.0)
        return self.start + (numbers - self.low) / self.scale

    def ticks(self, most: int) -> Ticks:
        """Returns at most about `most` ticks at round values. A logarithmic axis that holds two
        powers of ten or more has its ticks at powers of ten."""
        low = self.low
        high = self.high
        if self.logarithmic:
            first = math.ceil(low - 1e-9)
            last = math.floor(high + 1e-9)
            if last > first:
                decades_per_tick = -(-(last - first + 1) // most)
                powers = np.arange(first, last + 1, decades_per_tick)
                texts = [power_of_ten(power) for power in powers.tolist()]
                return list(zip(self.along(10.0**powers).tolist(), texts, strict=True))
            low = 10.0**low
            high = 10.0**high
        unit = 10.0 ** math.floor(math.log10((high - low) / most))
        step = next(unit * k for k in (1, 2, 5, 10) if high - low <= most * unit * k)
        values = step * np.arange(math.ceil(low / step), math.floor(high / step) + 1)
        texts = [f"{value:g}" for value in values]
        return list(zip(self.along(values).tolist(), texts, strict=True))
