"""How long a method stays right on any motion whose error has a series in the step (THEORY.md, 13).

The series is followed until the error is large, and carried on as it grew: exponentially where the
motion itself parts neighbours, by the time and its square elsewhere, not at all where it dies.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.stability import LEVELS, Growth, LongRun
from plumbob.analytic.theory import Coefficients

FIRST, LONGEST = 30, 300  # fastest periods that a series is followed for, at first and at most
MORE = 2.0  # times as long, the next time
KNOWN = 23.0  # e-folds, after which 10^-10 of an orbit is as large as the orbit
SAMPLES = 48  # of a fastest period
BEGUN = 8.0  # part of a run from which on the envelope of its errors is fitted
# Calibrated (test_long_runs.py: damped, forced and rotating motions): of the largest error so far,
# that of the last quarter where it dies, and that of the first half where it grows no more.
DIES, STAYS = 0.5, 0.85


def followed(
    series: Callable[[Array], Coefficients],
    scales: Mapping[str, float],
    step: float,
    fastest: float,
    lasts: float = math.inf,
    exponent: float = 0.0,
) -> LongRun | None:
    """The growth of the error of a scheme with a `series` at times [s], at a `step` [s] and over
    these `scales`, on a motion of a `fastest` period [s] that `lasts` so long [s] and parts
    neighbours at the rate `exponent` [1/s]; None without a series."""
    longest = min(lasts, LONGEST * fastest)
    enough = LEVELS[1] if math.isinf(lasts) else math.inf
    if exponent:
        longest = min(longest, KNOWN / exponent)
        enough = LEVELS[-1]
    until = min(FIRST * fastest, longest)
    while True:
        times = np.linspace(0.0, until, math.ceil(SAMPLES * until / fastest) + 1)
        terms = series(times)
        if not terms:
            return None
        size = np.zeros_like(times)
        for name, scale in scales.items():
            error = sum(step**order * errors[name] for order, errors in terms.items())
            size = np.maximum(size, np.abs(error) / scale)
        if size.max() > enough or until >= longest:
            return _carried_on(times, size, exponent)
        until = min(MORE * until, longest)


def _carried_on(times: Array, size: Array, exponent: float) -> LongRun:
    """The growth of the largest errors, shape (n,), at `times` [s], shape (n,)."""
    until = float(times[-1])
    half = float(size[: len(size) // 2].max())
    largest = float(size.max())
    last = float(size[3 * len(size) // 4 :].max())
    offset, linear, quadratic = _envelope(times, size)
    growth: Growth = "linear" if linear > quadratic * until else "quadratic"
    rate = linear if growth == "linear" else quadratic
    if exponent:
        growth, rate = "exponential", exponent
    elif last < DIES * largest:
        growth, rate = "decaying", 0.0
    elif half > STAYS * largest:
        growth, rate = "constant", 0.0

    def reached(level: float) -> float:
        above = np.flatnonzero(size >= level)
        if above.size:
            return float(times[above[0]])
        if not rate:
            return math.inf
        if exponent:
            return until + math.log(level / last) / rate
        rise = level - offset
        return 2.0 * rise / (linear + math.sqrt(linear**2 + 4.0 * quadratic * rise))

    return LongRun(growth, rate, 0.0, {level: reached(level) for level in LEVELS})


def _envelope(times: Array, size: Array) -> tuple[float, float, float]:
    """c, a and b of c + a t + b t^2 next to the largest errors up to each of `times` [s], a and b
    not negative; b is zero where those leave a straight line by no more than they jump."""
    from scipy.optimize import lsq_linear

    later = times > times[-1] / BEGUN
    until = times[-1]
    largest = np.maximum.accumulate(size)[later]
    powers = np.vander(times[later] / until, 3, increasing=True)
    curved, straight = (
        lsq_linear(powers[:, :count], largest, ([-np.inf, 0.0, 0.0][:count], np.inf)).x
        for count in (3, 2)
    )
    apart = np.abs(powers @ curved - powers[:, :2] @ straight).max()
    jumps = np.abs(powers @ curved - largest).max()
    offset, linear, quadratic = curved if apart > jumps else (*straight, 0.0)
    return float(offset), float(linear / until), float(quadratic / until**2)
