"""Long-run growth of a method's error on a motion whose error has a series in the step.

The series is evaluated until the error is large. After that time the error is extrapolated. On a
chaotic motion it grows exponentially, on other motions with the time and its square. If the error
dies away, it is not extrapolated. Derivation: THEORY.md, section 13.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.stability import LEVELS, Growth, LongRun
from plumbob.analytic.theory import Coefficients

# fastest periods in the first evaluation, and in the longest
FIRST_PERIODS, LONGEST_PERIODS = 30, 300
EVALUATION_FACTOR = 2.0  # factor from one evaluation's duration to the next
# e-folds: an uncertainty of 1e-10 has grown to the size of the orbit
LARGEST_GROWTH_EXPONENT = 23.0
ORBIT_SAMPLES_PER_PERIOD = 48  # samples in a fastest period
UNFITTED_PART = 8.0  # the envelope is not fitted to the first eighth of the run
# Both are calibrated on damped, forced and rotating motions (test_long_runs.py).
# An error decays if its last quarter stays below this fraction of its largest value.
DECAYING_BELOW = 0.5
# An error is constant if its first half exceeds this fraction of its largest value.
CONSTANT_ABOVE = 0.85


def long_run_by_series(
    series: Callable[[Array], Coefficients],
    scales: Mapping[str, float],
    step: float,
    fastest: float,
    lasts: float = math.inf,
    exponent: float = 0.0,
) -> LongRun | None:
    """Returns the long-run growth of a scheme's error; None if the scheme has no series.

    `series` gives the coefficients of the error at times [s]. `scales` are the units of the
    observables in which the error is measured. `fastest` is the motion's shortest period [s].
    `lasts` is the time [s] after which a damped motion is at rest. `exponent` [1/s] is the rate at
    which neighbours of a chaotic motion separate; 0 for other motions.
    """
    longest = min(lasts, LONGEST_PERIODS * fastest)
    largest_needed = LEVELS[1] if math.isinf(lasts) else math.inf
    if exponent:
        longest = min(longest, LARGEST_GROWTH_EXPONENT / exponent)
        largest_needed = LEVELS[-1]
    until = min(FIRST_PERIODS * fastest, longest)
    while True:
        times = np.linspace(
            0.0, until, math.ceil(ORBIT_SAMPLES_PER_PERIOD * until / fastest) + 1
        )
        terms = series(times)
        if not terms:
            return None
        relative_error = np.zeros_like(times)
        for name, scale in scales.items():
            error = sum(step**order * errors[name] for order, errors in terms.items())
            relative_error = np.maximum(relative_error, np.abs(error) / scale)
        if relative_error.max() > largest_needed or until >= longest:
            return _extrapolated_run(times, relative_error, exponent)
        until = min(EVALUATION_FACTOR * until, longest)


def _extrapolated_run(times: Array, relative_error: Array, exponent: float) -> LongRun:
    """Returns the kind and rate of growth of an error, and the times at which it reaches LEVELS.

    `relative_error` is the ratio of the error to its scale at `times` [s], both of shape (n,).
    `exponent` [1/s] is the rate of a chaotic motion, else 0.
    """
    count = len(relative_error)
    until = float(times[-1])
    largest = float(relative_error.max())
    largest_in_first_half = float(relative_error[: count // 2].max())
    largest_in_last_quarter = float(relative_error[3 * count // 4 :].max())
    offset, linear, quadratic = _envelope(times, relative_error)
    growth: Growth = "linear" if linear > quadratic * until else "quadratic"
    rate = linear if growth == "linear" else quadratic
    if exponent:
        growth, rate = "exponential", exponent
    elif largest_in_last_quarter < DECAYING_BELOW * largest:
        growth, rate = "decaying", 0.0
    elif largest_in_first_half > CONSTANT_ABOVE * largest:
        growth, rate = "constant", 0.0

    def time_of_level(level: float) -> float:
        """Returns the time [s] at which the relative error first reaches a `level`; infinite if it
        never does."""
        above = np.flatnonzero(relative_error >= level)
        if above.size:
            return float(times[above[0]])
        if not rate:
            return math.inf
        if exponent:
            return until + math.log(level / largest_in_last_quarter) / rate
        rise = level - offset
        return 2.0 * rise / (linear + math.sqrt(linear**2 + 4.0 * quadratic * rise))

    return LongRun(growth, rate, 0.0, {level: time_of_level(level) for level in LEVELS})


def _envelope(times: Array, relative_error: Array) -> tuple[float, float, float]:
    """Returns c, a and b of the envelope c + a t + b t^2 of an error, with a and b at least 0.

    The envelope is fitted to the largest error up to each of the `times` [s]. If a straight line
    and the parabola differ by less than the errors jump, the straight line is returned: b = 0.
    """
    from scipy.optimize import lsq_linear

    until = times[-1]
    fitted = times > until / UNFITTED_PART
    largest_so_far = np.maximum.accumulate(relative_error)[fitted]
    powers = np.vander(times[fitted] / until, 3, increasing=True)
    lowest = [-np.inf, 0.0, 0.0]  # smallest values of the coefficients
    parabola = lsq_linear(powers, largest_so_far, (lowest, np.inf)).x
    line = lsq_linear(powers[:, :2], largest_so_far, (lowest[:2], np.inf)).x
    difference = np.abs(powers @ parabola - powers[:, :2] @ line).max()
    jumps = np.abs(powers @ parabola - largest_so_far).max()
    offset, linear, quadratic = parabola if difference > jumps else (*line, 0.0)
    return float(offset), float(linear / until), float(quadratic / until**2)
