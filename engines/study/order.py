"""Observed order of convergence: the slope of log error against log step, with its confidence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from plumbob.analytic.reference import Array

# smallest number of steps: leaves two degrees of freedom for the confidence interval
MIN_STEP_SIZES = 4
MOST_STEPS = 6  # largest number of steps that an order is fitted to


@dataclass(frozen=True)
class Order:
    """An observed order of convergence with its 95 % confidence interval."""

    slope: float
    low: float  # lower end of the interval
    high: float  # upper end of the interval
    steps: tuple[float, ...]  # [s] steps that the slope was fitted to


def fit_order(
    steps: ArrayLike, errors: ArrayLike, floors: ArrayLike, most: int = MOST_STEPS
) -> Order | None:
    """The order fitted to at most `most` of the finest steps whose error is above ten times its
    round-off floor; None if there are fewer than MIN_STEP_SIZES such steps. Arguments have shape
    (n,): steps [s], errors, and floors of the errors."""
    # Imported here: reading a stored order needs no fit, and scipy takes long to load.
    from scipy.special import stdtrit

    h, e = (np.asarray(v, dtype=float) for v in (steps, errors))
    chosen = _fitted_indices(steps, errors, floors, most)
    if chosen.size < MIN_STEP_SIZES:
        return None
    (slope, _), covariance = np.polyfit(np.log(h[chosen]), np.log(e[chosen]), 1, cov=True)
    freedom = chosen.size - 2
    margin = float(stdtrit(freedom, 0.975) * np.sqrt(covariance[0, 0]))
    used = tuple(float(s) for s in np.sort(h[chosen])[::-1])
    return Order(float(slope), float(slope) - margin, float(slope) + margin, used)


def order_and_prediction(
    steps: ArrayLike, errors: ArrayLike, floors: ArrayLike, predicted: ArrayLike
) -> tuple[float | None, float | None]:
    """The order that `fit_order` fits to `errors`, and the order of the `predicted` errors at the
    same steps, both without intervals. The first is None if it cannot be fitted; the second is None
    too if a predicted error is NaN or zero. Arguments have shape (n,)."""
    h, e, p = (np.asarray(v, dtype=float) for v in (steps, errors, predicted))
    chosen = _fitted_indices(steps, errors, floors, MOST_STEPS)
    if chosen.size < MIN_STEP_SIZES:
        return None, None
    return _slope(h[chosen], e[chosen]), _slope(h[chosen], p[chosen])


def _slope(steps: Array, errors: Array) -> float | None:
    """The slope of log error against log step by least squares; None if an error is not positive.
    Arguments have shape (n,)."""
    if not (errors > 0.0).all():
        return None
    x, y = np.log(steps), np.log(errors)
    x = x - x.mean()
    return float(x @ y / (x @ x))


def _fitted_indices(
    steps: ArrayLike, errors: ArrayLike, floors: ArrayLike, most: int
) -> npt.NDArray[np.intp]:
    """The indices of at most `most` of the finest steps whose error is above ten times its
    round-off floor, finest first. Arguments have shape (n,)."""
    h, e, floor = (np.asarray(v, dtype=float) for v in (steps, errors, floors))
    usable = np.flatnonzero(np.isfinite(e) & (e > 10.0 * floor) & (e > 0.0))
    return usable[np.argsort(h[usable])][:most]
