"""Samples of a motion for the screen, between which its script interpolates linearly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals

# of an exact answer: forty in each of forty swings, 2e-3 of whose range they follow
COUNT = 1601
STEPS = 2**24 - 1  # over the range of a channel: errors are drawn many times as large


@dataclass(frozen=True)
class Samples:
    """Channels at times: SI, shape (n,) each."""

    times: Array  # [s]
    channels: Signals


def coded(values: Array) -> Any:
    """An array, shape (n,), as JSON: a number where it is constant, else third differences of whole
    numbers of STEPS over its range: of a smooth motion they are small, and compress to a third."""
    low = float(values.min())
    high = float(values.max())
    if low == high:
        return low
    numbers = np.rint((values - low) * (STEPS / (high - low))).astype(np.int64)
    for _ in range(3):
        numbers = np.diff(numbers, prepend=0)
    return {"low": low, "step": (high - low) / STEPS, "differences": numbers.tolist()}
