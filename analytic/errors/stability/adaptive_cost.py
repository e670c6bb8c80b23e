"""Cost of stiffness for a solver that chooses its own steps, which never becomes unstable."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.stability.largest_step import LEAST_STEPS, Complex
from plumbob.analytic.stability import LOST_GROWTH
from plumbob.analytic.tableau import Tableau

FARTHEST = 20.0  # of |h lambda|, at which stability is looked for
GRID = 4000


def stability_function(tableau: Tableau, z: Complex) -> Complex:
    """R(z) = 1 + z b^T (I - zA)^-1 1 of a Runge-Kutta method: what a step makes of 1 on x' = lambda
    x, at z = h lambda of any shape (eq. 13.1)."""
    change = tableau.change(lambda time, state: z * state, 0.0, np.ones_like(z), 1.0)
    return np.asarray(1.0 + change)


def stability_interval(tableau: Tableau, direction: complex) -> float:
    """The largest |z| in a `direction` of the complex plane up to which |R(z)| is at most 1, but
    for the growth LOST_GROWTH in LEAST_STEPS. The direction is -1 for a mode that decays, i for a
    mode that oscillates."""
    distance = np.linspace(0.0, FARTHEST, GRID + 1)[1:]
    points = np.asarray(distance * (direction / abs(direction)), dtype=np.complex128)
    size = np.abs(stability_function(tableau, points))
    beyond = np.flatnonzero(size > LOST_GROWTH ** (1.0 / LEAST_STEPS))
    return float(distance[beyond[0]]) if beyond.size else FARTHEST


def stiffness_cost(tableau: Tableau | None, rates: Complex) -> float:
    """Steps per second [1/s] that stability alone asks of a solver of modes with these `rates`
    [1/s] (eq. 13.6), whatever the tolerance; 0 for an implicit solver, None."""
    if tableau is None:
        return 0.0
    decaying = [rate for rate in rates if rate.real <= 0.0 and rate]
    return max(
        (abs(rate) / stability_interval(tableau, rate) for rate in decaying), default=0.0
    )
