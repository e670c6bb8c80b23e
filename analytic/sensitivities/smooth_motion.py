"""Sensitivities of a smooth motion by the variational equation.

Of z' = f(t, z; p) from z(0; p), the derivative S = dz/dp at fixed time obeys

    S' = f_z S + f_p,     S(0) = dz(0)/dp,                                                      (1)

(Hairer, Norsett and Wanner 1993, Solving Ordinary Differential Equations I, I.14), and that of an
observable o(t, z; p) is o_z S + o_p. z(t) is the exact motion, whatever gives it, so that S exists
on a separatrix too, where a closed form has no derivative: f is smooth, and t finite. It is solved
with two numbers of stages, whose difference is part of the uncertainty.
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

STAGES, FEWER = 12, 9  # of the collocation, and of the one that shows its error
RESOLVED, HALVINGS = 1e-11, 4  # relative difference of the two, and halvings of the step for it


def smooth_gradients(
    equations: Callable[[Any], SmoothMotion], problems: Sequence[Neighbours[Any]], times: Array
) -> list[Sensitivity]:
    """Sensitivities at `times` [s], shape (n,), by each parameter, of problems whose `equations`
    are those of a smooth motion: eq. 1."""
    motions = [one.each(equations) for one in problems]
    found, missed = _resolved(motions, times)
    states = motions[0].here.state(times)
    return [
        read_along(one, times, states, found[..., k].T, missed[..., k].T)
        for k, one in enumerate(motions)
    ]


def _resolved(motions: Sequence[Neighbours[SmoothMotion]], times: Array) -> Derived:
    """S at `times` and its uncertainty, shape (n, d, parameters)."""
    last = float(np.max(times, initial=0.0)) or 1.0
    count = len(motions)
    steps = len(motions[0].here.grid(last).breakpoints)
    for _ in range(1 + HALVINGS):
        grid = TimeGrid(np.linspace(0.0, last, steps))
        along = np.append(times, grid.breakpoints)  # what has decayed beside what it was
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
    """S at `times`, shape (n, d, 2 parameters): the second half of its columns is the response to
    the uncertainties of f_p and of the start."""
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
    """Sensitivity o_z S + o_p of what neighbours `read` of `times`, shape (n,), and `states`, shape
    (d, n), whose S is `change`, and its uncertainty `missed`; o_z by imaginary parts."""
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
