"""By how much an error may differ from what theory says of it, at each sample: what follows in a
series, rounding, and what a second run shows of a solver that controls its local error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from plumbob.analytic.reference import Array

# Of the difference to a second run with a much smaller tolerance: its error is at most half.
SURE = 2.0


def by_series(terms: Sequence[Array]) -> Array:
    """The remainder of a series in the step after its `terms`, shape (n,) each and of rising power:
    less than its last two (near-symmetric schemes can have tiny alternate terms), at their largest
    so far. Its coefficients hold what is nonlinear in the error, but for the part that
    `nonlinear_part` bounds."""
    return np.maximum.accumulate(np.abs(terms[-2:]).sum(axis=0))


def nonlinear_part(terms: Mapping[int, float], nonlinearity: float) -> float:
    """The part of an error that is added by the lowest degree in the error of which a series keeps
    nothing; its `terms` are {p: largest |C_p| step^p}. With a leading power p, a term of degree j
    begins at the power j p and is nonlinearity^(j - 1) of the error (THEORY.md, eq. 1.3)."""
    leading = max(terms, key=lambda power: terms[power])
    return min(1.0, nonlinearity) ** (max(terms) // leading)


def by_rounding(doubt: Array, steps: int) -> Array:
    """The effect of rounding on an error whose exact answer double precision allows `doubt`: at a
    moment at which the inputs matter little, what steps have rounded before is still there."""
    return np.maximum.accumulate(doubt) * roundings(steps)


def roundings(steps: int) -> float:
    """The effect of rounding in so many steps, in that of one unit in the last place of the inputs:
    theirs, and half a unit of every step, which adds up as a random walk, four standard deviations
    of it."""
    return 1.0 + 2.0 * float(np.sqrt(steps))


def by_second_run(error: Array, other: Array) -> Array:
    """A bound on a solver's error by that of a second run, which is at most half of it: twice the
    difference, at its largest so far."""
    return np.maximum.accumulate(SURE * np.abs(error - other))
