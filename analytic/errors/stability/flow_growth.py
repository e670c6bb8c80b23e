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
LOST = 1e6  # growth in a run beyond which a nudge of 1e-6 makes another motion of it in any case
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


def flow_growth(times: Array, tangents: Array, repeats: bool) -> FlowGrowth:
    """The growth of `tangents`, derivatives of the state by the start over their scales, shape (n,
    d, d), at `times` [s], shape (n,), from 0 to a period where the motion `repeats`.

    After n periods S(t) M^n = S(t) (1 + n (M - 1)) on a motion whose neighbours have other periods
    and keep to them (eq. 13.5); elsewhere growth that lasts to the end goes on."""
    norms, until = np.linalg.norm(tangents, ord=2, axis=(1, 2)), times[-1]
    largest = np.maximum.accumulate(np.maximum(norms, 1.0))
    if repeats:
        sheared = tangents @ (tangents[-1] - np.eye(tangents.shape[1]))
        most = float(np.linalg.norm(sheared, ord=2, axis=(1, 2)).max())
        return FlowGrowth(times, largest, most / until)
    folds = math.log(norms[-1] / norms[len(norms) // 2])
    if folds > EXPONENTIAL:
        return FlowGrowth(times, largest, exponent=2.0 * folds / until)
    return FlowGrowth(times, largest, slope=float(norms[-1]) / until if folds > 0.0 else 0.0)
