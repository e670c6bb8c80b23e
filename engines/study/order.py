"""Observed order of convergence: the slope of log error against log step, with its confidence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

MIN_STEP_SIZES = (
    4  # smallest number of steps: leaves two degrees of freedom for the confidence interval
)


@dataclass(frozen=True)
class Order:
    """An observed order of convergence with its 95 % confidence interval."""

    slope: float
    low: float  # lower end of the interval
    high: float  # upper end of the interval
    steps: tuple[float, ...]  # [s] steps that the slope was fitted to


def fit_order(
    steps: ArrayLike, errors: ArrayLike, floors: ArrayLike, most: int = 6
) -> Order | None:
    """The order fitted to at most `most` of the finest steps whose error is above ten times its
    round-off floor; None if there are fewer than MIN_STEP_SIZES such steps. Arguments have shape
    (n,): steps [s], errors, and floors of the errors."""
    # Imported here: reading a stored order needs no fit, and scipy takes long to load.
    from scipy.special import stdtrit

    h, e, floor = (np.asarray(v, dtype=float) for v in (steps, errors, floors))
    usable = np.isfinite(e) & (e > 10.0 * floor) & (e > 0.0)
    chosen = np.flatnonzero(usable)
    chosen = chosen[np.argsort(h[chosen])][:most]
    if chosen.size < MIN_STEP_SIZES:
        return None
    (slope, _), covariance = np.polyfit(np.log(h[chosen]), np.log(e[chosen]), 1, cov=True)
    freedom = chosen.size - 2
    margin = float(stdtrit(freedom, 0.975) * np.sqrt(covariance[0, 0]))
    used = tuple(float(s) for s in np.sort(h[chosen])[::-1])
    return Order(float(slope), float(slope) - margin, float(slope) + margin, used)
