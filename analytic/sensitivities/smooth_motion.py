"""Sensitivities of a smooth motion by the variational equation.

The solution of z' = f(t, z; p) from z(0; p) has a derivative S = dz/dp at fixed time, which obeys

    S' = f_z S + f_p,     S(0) = dz(0)/dp,                                                      (1)

(Hairer, Norsett and Wanner 1993, Solving Ordinary Differential Equations I, I.14). The derivative
of an observable o(t, z; p) is o_z S + o_p. z(t) is the exact motion from any source. Since f is
smooth and t finite, S exists on a separatrix too, on which a closed form has no derivative. Eq. 1
is solved with two numbers of stages. The difference of the two results is part of the uncertainty.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.numerics.collocation import TimeGrid
from plumbob.analytic.numerics.smooth.smooth_motion import SmoothMotion
from plumbob.analytic.numerics.smooth.smooth_system import TINY
from plumbob.analytic.reference import Array
from plumbob.analytic.sensitivities.neighbours import (
    Derived,
    Neighbours,
    Sensitivity,
    in_rows,
    stacked,
)

STAGES, FEWER = 12, 9  # stages of the collocation, and of a second one that shows its error
RESOLVED, HALVINGS = 1e-11, 4  # largest relative difference of the two; halvings to reach it


def smooth_gradients(
    equations: Callable[[Any], SmoothMotion], problems: Sequence[Neighbours[Any]], times: Array
) -> list[Sensitivity]:
    """Returns the sensitivities at `times` [s], shape (n,), by each parameter (eq. 1).

    `problems` has the neighbours by one parameter each. `equations` gives the smooth motion of a
    problem.
    """
    motions = [one.each(equations) for one in problems]
    found, missed = _resolved(motions, times)
    states = motions[0].here.state(times)
    return [
        read_along(one, times, states, found[..., k].T, missed[..., k].T)
        for k, one in enumerate(motions)
    ]


def _resolved(motions: Sequence[Neighbours[SmoothMotion]], times: Array) -> Derived:
    """Returns S at `times` [s] and its uncertainty, shape (n, d, parameters) each.

    The step of the collocation is halved until the two numbers of stages agree.
    """
    last = float(np.max(times, initial=0.0)) or 1.0
    count = len(motions)
    steps = len(motions[0].here.grid(last).breakpoints)
    for _ in range(1 + HALVINGS):
        grid = TimeGrid(np.linspace(0.0, last, steps))
        # The breakpoints give the largest size of S, also if S has decayed at `times`.
        along = np.append(times, grid.breakpoints)
        fine, coarse = (_response(grid, motions, stages, along) for stages in (STAGES, FEWER))
        apart = np.abs(fine - coarse)[..., :count]
        found = fine[..., :count]
        largest = np.abs(found).max(axis=0)
        if (apart <= RESOLVED * largest).all():
            break
        steps *= 2
    missed = apart + np.abs(fine[..., count:]) + ROUNDOFF * steps * largest
    return found[: len(times)], missed[: len(times)]


def _response(
    grid: TimeGrid, motions: Sequence[Neighbours[SmoothMotion]], stages: int, times: Array
) -> Array:
    """Returns S at `times` [s], shape (n, d, 2 parameters).

    The second half of the columns is the response to the uncertainties of f_p and of the start.
    """
    nodes, states, flow = motions[0].here.linearised(grid, stages)
    forcing = stacked(
        [one.derivative(lambda motion: motion.slope(nodes, states)) for one in motions]
    )
    start = stacked([one.derivative(lambda motion: motion.start) for one in motions])
    across = forcing.transpose(1, 0, 2)
    return flow.respond(start, across.reshape(*flow.matrix.shape[:3], -1)).at(times)


def read_along(
    motions: Neighbours[Any], times: Array, states: Array, change: Array, missed: Array
) -> Sensitivity:
    """Returns the sensitivities o_z S + o_p of the observables on one motion.

    The neighbours `read` observables from `times` [s], shape (n,), and `states`, shape (d, n). S is
    `change`, its uncertainty `missed`, both of shape (d, n). o_z is computed by imaginary parts.
    """
    here: Any = motions.here
    names = list(here.read(times, states))

    def ahead(direction: Array) -> Array:
        moved = here.read(times, states + 1j * TINY * direction)
        return in_rows(moved, names).imag / TINY

    direct, uncertain = motions.derivative(lambda m: in_rows(m.read(times, states), names))
    values = direct + ahead(change)
    for row, size in enumerate(missed):
        alone = np.zeros_like(states)
        alone[row] = size
        uncertain = uncertain + np.abs(ahead(alone))
    return Sensitivity(
        dict(zip(names, values, strict=True)), dict(zip(names, uncertain, strict=True))
    )
