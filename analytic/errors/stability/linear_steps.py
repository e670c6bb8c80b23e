"""One step of a scheme on a linear system: its stability function, or its Jacobian as a matrix."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from plumbob.analytic.errors.smooth_motion.scheme_steps import Advance, Parts
from plumbob.analytic.reference import Array
from plumbob.analytic.tableau import Tableau

TINY = 1e-30  # an imaginary part that is a nudge: its square is lost in a double
Complex = npt.NDArray[np.complex128]
Matrices = Callable[[Array], Array | Complex]
"""Step sizes [s], shape (n,) -> matrices of a step, shape (n, m, m)."""


def stability_function(tableau: Tableau, z: Complex) -> Complex:
    """R(z) = 1 + z b^T (I - zA)^-1 1 of a Runge-Kutta method: what a step makes of 1 on x' = lambda
    x, at z = h lambda of any shape (eq. 13.1)."""
    change = tableau.change(lambda time, state: z * state, 0.0, np.ones_like(z), 1.0)
    return np.asarray(1.0 + change)


def jacobians(advance: Advance, state: Parts, count: int) -> Array:
    """The derivative of a step of `count` sizes at once, at a state of d numbers or arrays of shape
    (count,), by imaginary parts: shape (count, d, d)."""
    columns = []
    for varied in range(len(state)):
        nudges = (TINY * 1j * (varied == i) for i in range(len(state)))
        nudged = [np.zeros(count) + x + nudge for x, nudge in zip(state, nudges, strict=True)]
        after = [np.imag(part) / TINY for part in advance(0.0, nudged)]
        columns.append(np.stack(after, axis=-1))
    return np.stack(columns, axis=-1)
