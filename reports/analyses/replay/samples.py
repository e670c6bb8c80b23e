"""Samples of a motion for the screen: as many as keep a body within a fraction of a pixel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array

COUNTS = (201, 401, 801, 1601, 3201)  # samples of the exact answer over the whole replay
WITHIN = 1e-3  # of a channel's range, or of 1 where an angle goes many turns: 0.2 pixel
STILL = 1e-9  # of a channel, in SI: what is nearer is rounding
STEPS = 2**24 - 1  # over the range of a channel: errors are drawn many times as large
Channels = Mapping[str, Array]


@dataclass(frozen=True)
class Samples:
    """Channels at times: SI, shape (n,) each."""

    times: Array  # [s]
    channels: Channels


def sampled(
    motion: Callable[[Array], Channels],
    seconds: float,
    held: Sequence[str],
    cubic: bool,
) -> Samples:
    """Samples of `motion` at equal intervals over `seconds` [s]: as few as interpolate the channels
    `held`, by a cubic or linearly, to a pixel's fraction."""
    times = np.linspace(0.0, seconds, COUNTS[0])
    samples = motion(times)
    for count in COUNTS[1:]:
        finer = np.linspace(0.0, seconds, count)
        exact = motion(finer)
        if all(
            _departure(samples[name], exact[name], cubic)
            <= max(WITHIN * min(np.ptp(exact[name]), 1.0), STILL)
            for name in held
        ):
            break
        times, samples = finer, exact
    return Samples(times, samples)


def _departure(coarse: Array, fine: Array, cubic: bool) -> float:
    """Largest difference at the midpoints between samples of a channel interpolated as the page's
    script does, and `fine`, which has one more sample between any two."""
    if not cubic:
        between = 0.5 * (coarse[1:] + coarse[:-1])
        return float(np.abs(between - fine[1::2]).max())
    inner = (9.0 * (coarse[1:-2] + coarse[2:-1]) - coarse[:-3] - coarse[3:]) / 16.0
    return float(np.abs(inner - fine[3:-3:2]).max())


def coded(values: Array) -> Any:
    """An array, shape (n,), as JSON: a number where it is constant, else third differences of whole
    numbers of STEPS over its range: of a smooth motion they are small, and compress to a third."""
    low, high = float(values.min()), float(values.max())
    if low == high:
        return low
    numbers = np.rint((values - low) * (STEPS / (high - low))).astype(np.int64)
    for _ in range(3):
        numbers = np.diff(numbers, prepend=0)
    return {"low": low, "step": (high - low) / STEPS, "differences": numbers.tolist()}
