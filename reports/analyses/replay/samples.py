"""Samples of a motion for the screen: as many as keep a body within a fraction of a pixel."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array

COUNTS = (201, 401, 801, 1601, 3201)  # samples of the exact answer over the whole replay
WITHIN = 1e-3  # of a channel's range: 0.2 pixel of 200
TURN = 1e-3  # [rad] of an angle, whose range may be many turns: the same
STEPS = 65535  # of a 16-bit number
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
    """An array, shape (n,), as JSON: a number where it is constant, else 16-bit numbers over its
    range; 32-bit floats for a `place`, an angle or a length, that these would not resolve to a
    tenth of what it may depart by. Both little-endian, in base64."""
    low, high = float(values.min()), float(values.max())
    if low == high:
        return low
    if place and high - low > 0.1 * TURN * STEPS:
        return floats(values)
    scaled = np.rint((values - low) * (STEPS / (high - low))).astype("<u2")
    return {"low": low, "high": high, "u2": base64.b64encode(scaled.tobytes()).decode()}


def floats(values: Array) -> Any:
    """An array, shape (n,), as JSON: a number where it is constant, else 32-bit floats."""
    if float(np.ptp(values)) == 0.0:
        return float(values[0])
    return {"f4": base64.b64encode(values.astype("<f4").tobytes()).decode()}


def decoded(coded: Any, count: int) -> Array:
    """The array of `count` values that `coded` or `floats` made this of."""
    if isinstance(coded, float | int):
        return np.full(count, float(coded))
    if "f4" in coded:
        return np.frombuffer(base64.b64decode(coded["f4"]), "<f4").astype(np.float64)
    numbers = np.frombuffer(base64.b64decode(coded["u2"]), "<u2").astype(np.float64)
    return np.asarray(coded["low"] + numbers * ((coded["high"] - coded["low"]) / STEPS))
