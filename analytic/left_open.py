"""Bounds on the difference of an error from its prediction, at each sample.

The difference has three causes: the remainder of a series, rounding, and for a solver that controls
its local error, the unknown part that a second run shows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from plumbob.analytic.reference import Array

# Bound on the ratio of a solver's error to its difference from a second run with a much smaller
# tolerance: the error of the second run is at most half of the error of the first.
SOLVER_FACTOR = 2.0


def by_series(terms: Sequence[Array]) -> Array:
    """Returns a bound on the remainder of a series in the step, shape (n,).

    `terms` have rising powers and shape (n,) each. The bound is the largest sum so far of the last
    two: two, because near-symmetric schemes can have tiny alternate terms. The coefficients include
    the nonlinear response, except the part that `nonlinear_part` bounds.
    """
    return np.maximum.accumulate(np.abs(terms[-2:]).sum(axis=0))


def nonlinear_part(terms: Mapping[int, float], nonlinearity: float) -> float:
    """Returns the relative error by nonlinear terms that a truncated series lacks.

    `terms` are {p: largest |C_p| step^p}. If the leading power is p, terms of degree j in the error
    begin at the power j p, and are nonlinearity^(j - 1) times the error (THEORY.md, eq. 1.3). The
    result is for the lowest degree of which the series has no term.
    """
    leading = max(terms, key=lambda power: terms[power])
    return min(1.0, nonlinearity) ** (max(terms) // leading)


def by_rounding(doubt: Array, steps: int) -> Array:
    """Returns the effect of rounding on an error after a number of `steps`, shape (n,).

    `doubt` is the uncertainty of the exact solution, shape (n,). Its largest value so far counts:
    the effect of roundings in earlier steps remains at times that are less sensitive to the inputs.
    """
    return np.maximum.accumulate(doubt) * roundings(steps)


def roundings(steps: int) -> float:
    """Returns the effect of rounding in `steps`, in units of the effect of the inputs' last place.

    It is 1 for the inputs, plus four standard deviations of a random walk with half a unit for each
    step.
    """
    return 1.0 + 2.0 * float(np.sqrt(steps))


def by_second_run(error: Array, second_error: Array) -> Array:
    """Returns a bound on the `error` of a solver, shape (n,), from the `second_error` of a run with
    a much smaller tolerance.

    This assumes that the much smaller tolerance at least halves the error. The error is then at
    most twice the difference of both errors. The bound is SOLVER_FACTOR times the difference, and
    never falls with time.
    """
    return np.maximum.accumulate(SOLVER_FACTOR * np.abs(error - second_error))
