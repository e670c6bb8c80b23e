"""Cost of stiffness for a solver that chooses its own steps.

Such a solver never becomes unstable: stiffness makes its steps small, whatever the tolerance.
"""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.stability.largest_step import STABLE_STEPS, EigenvalueRates
from plumbob.analytic.stability import LOST_GROWTH
from plumbob.analytic.tableau import Tableau

FARTHEST = 20.0  # largest |h lambda| at which stability is tested
TESTED_PRODUCTS = 4000  # values of |h lambda| that are tested


def stability_function(tableau: Tableau, z: EigenvalueRates) -> EigenvalueRates:
    """Returns R(z) = 1 + z b^T (I - zA)^-1 1 of a Runge-Kutta method (eq. 13.1).

    R(z) is the state after one step on x' = lambda x from x = 1, with z = h lambda of any shape.
    """
    change = tableau.change(lambda time, state: z * state, 0.0, np.ones_like(z), 1.0)
    return np.asarray(1.0 + change)


def stability_interval(tableau: Tableau, direction: complex) -> float:
    """Returns the largest |z| along a `direction` of the complex plane up to which a step is
    stable.

    The direction is -1 for a mode that decays, i for a mode that oscillates. A step is stable if
    STABLE_STEPS of it grow by LOST_GROWTH at most: |R(z)| is about 1 or less.
    """
    distances = np.linspace(0.0, FARTHEST, TESTED_PRODUCTS + 1)[1:]
    points = np.asarray(distances * (direction / abs(direction)), dtype=np.complex128)
    growth = np.abs(stability_function(tableau, points))
    unstable = np.flatnonzero(growth > LOST_GROWTH ** (1.0 / STABLE_STEPS))
    return float(distances[unstable[0]]) if unstable.size else FARTHEST


def stiffness_cost(tableau: Tableau | None, rates: EigenvalueRates) -> float:
    """Returns the steps per second [1/s] that stability alone requires of a solver (eq. 13.6).

    `rates` are the eigenvalues [1/s] of the modes. Modes that grow in the exact motion are left
    out. `tableau` is None for an implicit solver, which needs no steps for stability: 0.
    """
    if tableau is None:
        return 0.0
    stable_rates = [rate for rate in rates if rate.real <= 0.0 and rate]
    steps_per_second = [abs(rate) / stability_interval(tableau, rate) for rate in stable_rates]
    return max(steps_per_second, default=0.0)
