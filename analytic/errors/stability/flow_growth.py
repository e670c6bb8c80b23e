"""Growth of a small change of the start along an exact motion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbob.analytic.numerics.smooth.smooth_motion import SmoothMotion
from plumbob.analytic.reference import Array

# e-folds in the second half of a motion above which its growth is exponential
EXPONENTIAL_FOLDS = 3.0
GROWTH_TO_MOTION_SIZE = 1e6  # growth at which a nudge of 1e-6 is as large as the motion
FLOW_SAMPLES_PER_PERIOD = 40  # samples in a fastest period
APERIODIC_PERIODS = 30  # fastest periods for which an aperiodic motion is followed


@dataclass(frozen=True)
class FlowGrowth:
    """Largest factor by which a nudge of the start has grown within a duration.

    The factor is computed up to `times[-1]`. Beyond, `slope` and `exponent` extrapolate it. A nudge
    is the norm of a small change of the state over the scales of the state.
    """

    times: Array  # [s], increasing from 0
    largest: Array  # largest factor up to each time, at least 1
    slope: float = 0.0  # [1/s] linear growth of the factor after the last time
    exponent: float = 0.0  # [1/s] exponential growth of the factor after the last time

    def __call__(self, durations: Any) -> Any:
        """Returns the largest factors within `durations` [s], a number or an array."""
        time_after = np.maximum(np.asarray(durations) - self.times[-1], 0.0)
        linear = np.interp(durations, self.times, self.largest) + self.slope * time_after
        folds = np.minimum(self.exponent * time_after, 600.0)  # a limit against overflow
        return np.asarray(linear * np.exp(folds))


def eigenvalues(motion: SmoothMotion, states: Array, parts: int) -> npt.NDArray[np.complex128]:
    """Returns the eigenvalues [1/s] of the linearised motion at n states, shape (n, parts).

    `states` has shape (d, n); the first `parts` numbers of a state are linearised, the rest is held
    fixed.
    """
    matrices = motion.jacobian(np.zeros(states.shape[1]), states)[:parts, :parts]
    return np.linalg.eigvals(np.moveaxis(matrices, -1, 0)).astype(np.complex128)


def fastest_flow_rate(rates: npt.NDArray[np.complex128], orbit: Array) -> float:
    """Returns the fastest rate [rad/s] of a motion; 1 if nothing moves.

    The rate is the largest eigenvalue among `rates` [1/s], or the largest speed of an angle that
    makes a full turn along the `orbit`. An orbit has n angles and then their n speeds, shape
    (2 n, m).
    """
    angles, speeds = np.split(orbit, 2)
    turns = np.ptp(angles, axis=1) > math.tau
    turning_rate = np.abs(speeds[turns]).max(initial=0.0)
    return float(max(np.abs(rates).max(), turning_rate)) or 1.0


def growth_along(
    motion: SmoothMotion, scales: Array, until: float, rate: float, repeats: bool
) -> FlowGrowth:
    """Returns the growth of a nudge of the first d numbers of a motion's state.

    `scales`, shape (d,), are the units of these numbers. The motion is followed up to the time
    `until` [s]: its period if it `repeats`. `rate` [rad/s] is the fastest rate of the motion.

    If the motion repeats, its neighbours are periodic too, with slightly different periods. The
    derivative of the state after n periods and a time t is then S(t) M^n = S(t) (1 + n (M - 1)),
    linear in n (eq. 13.5). If the motion does not repeat, the growth of its second half is
    extrapolated.
    """
    times = np.linspace(
        0.0, until, 1 + math.ceil(FLOW_SAMPLES_PER_PERIOD * until * rate / math.tau)
    )
    size = len(scales)
    tangents = motion.tangents(times)[:, :size, :size] * scales / scales[:, None]
    norms = np.linalg.norm(tangents, ord=2, axis=(1, 2))
    largest = np.maximum.accumulate(np.maximum(norms, 1.0))
    if repeats:
        growth_per_period = tangents @ (tangents[-1] - np.eye(size))
        largest_gain = np.linalg.norm(growth_per_period, ord=2, axis=(1, 2)).max()
        return FlowGrowth(times, largest, slope=float(largest_gain) / until)
    folds_in_second_half = math.log(norms[-1] / norms[len(norms) // 2])
    if folds_in_second_half > EXPONENTIAL_FOLDS:
        return FlowGrowth(times, largest, exponent=2.0 * folds_in_second_half / until)
    if folds_in_second_half > 0.0:
        return FlowGrowth(times, largest, slope=float(norms[-1]) / until)
    return FlowGrowth(times, largest)
