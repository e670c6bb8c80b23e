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
from plumbob.analytic.numerics.smooth.smooth_system import IMAGINARY_STEP
from plumbob.analytic.reference import Array
from plumbob.analytic.sensitivities.neighbours import (
    Derived,
    Neighbours,
    Sensitivity,
    in_rows,
    stacked,
)

# stages of the collocation, and of a second one that shows its error
SENSITIVITY_STAGES, CHECK_STAGES = 12, 9
# largest relative difference of the two; halvings to reach it
RESOLVED_DIFFERENCE, MAX_STEP_HALVINGS = 1e-11, 4


def smooth_gradients(
    equations: Callable[[Any], SmoothMotion], problems: Sequence[Neighbours[Any]], times: Array
) -> list[Sensitivity]:
    """Returns the sensitivities at `times` [s], shape (n,), by each parameter (eq. 1).

    `problems` has the neighbours by one parameter each. `equations` gives the smooth motion of a
    problem.
    """
    motions = [neighbours.each(equations) for neighbours in problems]
    derivatives, doubts = _state_derivatives(motions, times)
    states = motions[0].here.state(times)
    sensitivities = []
    for k, neighbours in enumerate(motions):
        change = derivatives[..., k].T
        doubt = doubts[..., k].T
        sensitivities.append(observable_sensitivity(neighbours, times, states, change, doubt))
    return sensitivities


def _state_derivatives(motions: Sequence[Neighbours[SmoothMotion]], times: Array) -> Derived:
    """Returns S of eq. 1 at `times` [s] and its uncertainty, shape (n, d, parameters) each.

    The step of the collocation is halved until the two numbers of stages agree.
    """
    last = float(np.max(times, initial=0.0)) or 1.0
    count = len(motions)
    steps = len(motions[0].here.grid(last).breakpoints)
    for _ in range(1 + MAX_STEP_HALVINGS):
        grid = TimeGrid(np.linspace(0.0, last, steps))
        # The breakpoints give the largest size of S, also if S has decayed at `times`.
        all_times = np.append(times, grid.breakpoints)
        fine = _response(grid, motions, SENSITIVITY_STAGES, all_times)
        coarse = _response(grid, motions, CHECK_STAGES, all_times)
        difference = np.abs(fine - coarse)[..., :count]
        derivatives = fine[..., :count]
        largest = np.abs(derivatives).max(axis=0)
        if (difference <= RESOLVED_DIFFERENCE * largest).all():
            break
        steps *= 2
    input_doubts = np.abs(fine[..., count:])
    doubts = difference + input_doubts + ROUNDOFF * steps * largest
    return derivatives[: len(times)], doubts[: len(times)]


def _response(
    grid: TimeGrid, motions: Sequence[Neighbours[SmoothMotion]], stages: int, times: Array
) -> Array:
    """Returns S of eq. 1 at `times` [s], shape (n, d, 2 parameters).

    The second half of the columns is the response to the uncertainties of f_p and of the start.
    """
    nodes, states, flow = motions[0].here.linearised(grid, stages)

    def slope(motion: SmoothMotion) -> Array:
        """Returns f, the slope of the state, on the exact motion with a neighbour's parameters."""
        return motion.slope(nodes, states)

    def initial_state(motion: SmoothMotion) -> Any:
        """Returns z(0), the state of a neighbour at the start."""
        return motion.start

    forcing = stacked([neighbours.derivative(slope) for neighbours in motions])
    start = stacked([neighbours.derivative(initial_state) for neighbours in motions])
    forcing_at_nodes = forcing.transpose(1, 0, 2).reshape(*flow.matrix.shape[:3], -1)
    return flow.respond(start, forcing_at_nodes).at(times)


def observable_sensitivity(
    motions: Neighbours[Any], times: Array, states: Array, change: Array, doubt: Array
) -> Sensitivity:
    """Returns the sensitivities o_z S + o_p of the observables on one motion.

    The neighbours `read` observables from `times` [s], shape (n,), and `states`, shape (d, n). S is
    `change`, its uncertainty `doubt`, both of shape (d, n). o_z is computed by imaginary parts.
    """
    here: Any = motions.here
    names = list(here.read(times, states))

    def read(motion: Any) -> Array:
        """Returns a neighbour's observables on the exact motion, shape (observables, n)."""
        return in_rows(motion.read(times, states), names)

    def derivative_along(direction: Array) -> Array:
        """Returns the derivatives of the observables along a `direction` of the state, o_z times
        the direction, shape (observables, n)."""
        nudged = here.read(times, states + 1j * IMAGINARY_STEP * direction)
        return in_rows(nudged, names).imag / IMAGINARY_STEP

    direct, uncertainty = motions.derivative(read)
    values = direct + derivative_along(change)
    for row, row_doubt in enumerate(doubt):
        direction = np.zeros_like(states)
        direction[row] = row_doubt
        uncertainty = uncertainty + np.abs(derivative_along(direction))
    return Sensitivity(
        dict(zip(names, values, strict=True)), dict(zip(names, uncertainty, strict=True))
    )
