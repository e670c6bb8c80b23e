"""By how much an exact motion magnifies a nudge of its start."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbob.analytic.numerics.smooth.smooth_motion import SmoothMotion
from plumbob.analytic.reference import Array

EXPONENTIAL = 3.0  # e-folds in the second half of a motion that make its growth one
# growth in a run beyond which a nudge of 1e-6 makes another motion of it in any case
LOST = 1e6
PARTS = 40  # of a fastest period, at which it is sampled
PERIODS = 30  # of the fastest mode, for which a motion without a period of its own is followed


@dataclass(frozen=True)
class FlowGrowth:
    """Largest factor within a duration: known up to `times[-1]`, beyond as `slope` and `exponent`
    carry it on. A nudge is measured in the state over its scales."""

    times: Array  # [s], increasing from 0
    largest: Array  # until each time, at least 1
    slope: float = 0.0  # of the largest [1/s]
    exponent: float = 0.0  # [1/s]

    def __call__(self, durations: Any) -> Any:
        """The factors within `durations` [s], a number or of any shape."""
        beyond = np.maximum(np.asarray(durations) - self.times[-1], 0.0)
        grown = np.interp(durations, self.times, self.largest) + self.slope * beyond
        return np.asarray(grown * np.exp(np.minimum(self.exponent * beyond, 600.0)))


def eigenvalues(motion: SmoothMotion, states: Array, parts: int) -> npt.NDArray[np.complex128]:
    """Those of the linearised motion's first `parts` at its states, shape (d, n); (n, parts)."""
    matrices = motion.jacobian(np.zeros(states.shape[1]), states)[:parts, :parts]
    return np.linalg.eigvals(np.moveaxis(matrices, -1, 0)).astype(np.complex128)


def fastest_rate(rates: npt.NDArray[np.complex128], orbit: Array) -> float:
    """The fastest rate [rad/s] of the linearised motion, or of an angle that turns on an `orbit`,
    angles and then their rates, shape (2 n, m)."""
    angles, speeds = np.split(orbit, 2)
    turned = np.abs(speeds[np.ptp(angles, axis=1) > math.tau]).max(initial=0.0)
    return float(max(np.abs(rates).max(), turned)) or 1.0


def growth_along(
    motion: SmoothMotion, scales: Array, until: float, rate: float, repeats: bool
) -> FlowGrowth:
    """The growth of nudges of a motion's first numbers, over their `scales`, shape (d,), which is
    followed `until` a time [s], its period where it `repeats`; `rate` is the fastest [rad/s].

    After n periods S(t) M^n = S(t) (1 + n (M - 1)) on a motion whose neighbours have other periods
    and keep to them (eq. 13.5); elsewhere growth that lasts to the end goes on."""
    times = np.linspace(0.0, until, 1 + math.ceil(PARTS * until * rate / math.tau))
    d = len(scales)
    tangents = motion.tangents(times)[:, :d, :d] * scales / scales[:, None]
    norms = np.linalg.norm(tangents, ord=2, axis=(1, 2))
    largest = np.maximum.accumulate(np.maximum(norms, 1.0))
    if repeats:
        sheared = tangents @ (tangents[-1] - np.eye(d))
        most = float(np.linalg.norm(sheared, ord=2, axis=(1, 2)).max())
        return FlowGrowth(times, largest, most / until)
    folds = math.log(norms[-1] / norms[len(norms) // 2])
    if folds > EXPONENTIAL:
        return FlowGrowth(times, largest, exponent=2.0 * folds / until)
    return FlowGrowth(times, largest, slope=float(norms[-1]) / until if folds > 0.0 else 0.0)
