"""Observed order of convergence: the slope of log error against log step, with its confidence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

LEAST = 4  # steps, so that two degrees of freedom are left for the confidence


@dataclass(frozen=True)
class Order:
    """Slope with its 95 % confidence interval, over the steps that it was fitted to."""

    slope: float
    low: float
    high: float
    steps: tuple[float, ...]


def fit_order(
    steps: ArrayLike, errors: ArrayLike, floors: ArrayLike, most: int = 6
) -> Order | None:
    """Fit the order to the finest steps whose error is above ten times its floor, `most` at most;
    None where fewer than four are. Arguments of shape (n,): steps [s], errors, round-off floors."""
    from scipy.special import stdtrit  # not above: reading a stored order fits nothing

    h, e, floor = (np.asarray(v, dtype=float) for v in (steps, errors, floors))
    usable = np.isfinite(e) & (e > 10.0 * floor) & (e > 0.0)
    chosen = np.flatnonzero(usable)
    chosen = chosen[np.argsort(h[chosen])][:most]
    if chosen.size < LEAST:
        return None
    (slope, _), covariance = np.polyfit(np.log(h[chosen]), np.log(e[chosen]), 1, cov=True)
    freedom = chosen.size - 2
    margin = float(stdtrit(freedom, 0.975) * np.sqrt(covariance[0, 0]))
    used = tuple(float(s) for s in np.sort(h[chosen])[::-1])
    return Order(float(slope), float(slope) - margin, float(slope) + margin, used)
