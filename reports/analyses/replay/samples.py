"""Samples of a motion for the screen; the page's script interpolates linearly between them."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.reference import Array

# samples of an exact motion: forty for each of forty swings, which keeps the interpolation within
# 2e-3 of the range
REPLAY_SAMPLES = 1601
RESOLUTION = 2**24 - 1  # resolution of a channel's range, fine enough for magnified errors


def encode_samples(values: Array, resolution: int = RESOLUTION) -> Any:
    """Returns an array, shape (n,), for JSON. A constant array becomes a number. The values
    of any other array are rounded to whole numbers from 0 to `resolution`, which become third
    differences: these are small for a smooth motion, and compress to a third."""
    low = float(values.min())
    high = float(values.max())
    if low == high:
        return low
    numbers = np.rint((values - low) * (resolution / (high - low))).astype(np.int64)
    for _ in range(3):
        numbers = np.diff(numbers, prepend=0)
    return {"low": low, "step": (high - low) / resolution, "differences": numbers.tolist()}
