"""Step sizes from large to small, in the round numbers that people use."""

from __future__ import annotations

import math


def step_sizes(coarse: float, fine: float) -> tuple[float, ...]:
    """Steps [s] 1, 2 and 5 times powers of ten, from `coarse` down to `fine`, both included."""
    decades = range(math.ceil(math.log10(coarse)), math.floor(math.log10(fine)) - 1, -1)
    # Through decimal text: 5e-4 is the double nearest to 0.0005, 5 * 10**-4 need not be.
    chosen_step_sizes = [
        float(f"{digit}e{exponent}") for exponent in decades for digit in (5, 2, 1)
    ]
    return tuple(h for h in chosen_step_sizes if fine * (1 - 1e-9) <= h <= coarse * (1 + 1e-9))
