"""Samples of a motion for the screen: as many as keep a body within a fraction of a pixel."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array

COUNTS = (201, 401, 801, 1601, 3201)  # samples of the exact answer over the whole replay
WITHIN = 1e-3  # of a channel's range: 0.2 pixel of 200
TURN = 1e-3  # [rad] of an angle, whose range may be many turns: the same
STEPS, FINE = 2**16 - 1, 2**24 - 1  # over the range of a channel
Channels = Mapping[str, Array]


@dataclass(frozen=True)
class Samples:
    """Channels at times: SI, shape (n,) each."""

    times: Array  # [s]
    channels: Channels


def sampled(
    motion: Callable[[Array], Channels],
    seconds: float,
    angles: frozenset[str],
    smooth: frozenset[str],
) -> Samples:
    """Samples of `motion` at equal intervals over `seconds` [s]: as few as interpolate the channels
    in `smooth` by a cubic, and `angles` among the others linearly, to a pixel's fraction."""
    times = np.linspace(0.0, seconds, COUNTS[0])
    samples = motion(times)
    for count in COUNTS[1:]:
        finer = np.linspace(0.0, seconds, count)
        exact = motion(finer)
        if all(
            _departure(samples[name], exact[name], name in smooth)
            <= _allowed(exact[name], name in angles)
            for name in angles | smooth
        ):
            break
        times, samples = finer, exact
    return Samples(times, samples)


def _allowed(values: Array, angle: bool) -> float:
    """How far an interpolated channel may depart from the exact one."""
    within = WITHIN * float(np.ptp(values))
    return min(within, TURN) if angle and np.ptp(values) > 1.0 else within


def _departure(coarse: Array, fine: Array, cubic: bool) -> float:
    """Largest difference at the midpoints between samples of a channel interpolated as the page's
    script does, and `fine`, which has one more sample between any two."""
    if not cubic:
        between = 0.5 * (coarse[1:] + coarse[:-1])
        return float(np.abs(between - fine[1::2]).max())
    inner = (9.0 * (coarse[1:-2] + coarse[2:-1]) - coarse[:-3] - coarse[3:]) / 16.0
    return float(np.abs(inner - fine[3:-3:2]).max())


def coded(values: Array, place: bool = True) -> Any:
    """An array, shape (n,), as JSON: a number where it is constant, else whole numbers of 65535
    steps over its range; of finer ones for a `place`, an angle or a length, that these would not
    resolve to a tenth of what it may depart by."""
    coarse = not place or float(np.ptp(values)) <= 0.1 * TURN * STEPS
    return _stepped(values, STEPS if coarse else FINE)


def fine(values: Array) -> Any:
    """The same in steps of 6e-8 of the range: errors are drawn many times as large."""
    return _stepped(values, FINE)


def _stepped(values: Array, steps: int) -> Any:
    """Third differences of the numbers of steps: of a smooth motion they are small, and compress
    to a third."""
    low, high = float(values.min()), float(values.max())
    if low == high:
        return low
    numbers = np.rint((values - low) * (steps / (high - low))).astype(np.int64)
    for _ in range(3):
        numbers = np.diff(numbers, prepend=0)
    return {"low": low, "step": (high - low) / steps, "differences": numbers.tolist()}


def decoded(coded: Any, count: int) -> Array:
    """The array of `count` values that `coded` or `fine` made this of."""
    if isinstance(coded, float | int):
        return np.full(count, float(coded))
    numbers = np.array(coded["differences"])
    for _ in range(3):
        numbers = np.cumsum(numbers)
    return np.asarray(coded["low"] + coded["step"] * numbers)
