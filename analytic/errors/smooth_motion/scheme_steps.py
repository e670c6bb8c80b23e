"""One step of each scheme on q'' = f(t, q, q'), for numbers, arrays or power series in the step."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.power_series import Series
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, TABLEAUX, Scheme
from plumbob.analytic.tableau import Tableau, advance_parts

MAX_SCHEME_STEPS = 2_000_000  # steps in a run, which take a few seconds
# [steps] largest distance of a sample from a whole number of steps
LARGEST_OFFSET = 1e-6
MAX_HALF_KICK_ITERATIONS = 100  # iterations for an implicit half kick
READ_AT = MappingProxyType({"start": 0.0, "midpoint": 0.5, "mean": 0.5})
"""Fraction of a step at which a held control is read, by kind of control."""
StepNumbers = npt.NDArray[np.int64]
StateParts = Sequence[Any]
SchemeStep = Callable[[Any, StateParts], StateParts]
"""Function from the time [s] and state at a step's start to the state after it: q and then q'."""
StageAcceleration = Callable[[Any, float, StateParts, StateParts], StateParts]
"""Function from the time [s] of a step's start, a fraction of the step, q and q' to q''."""


@dataclass(frozen=True)
class Equations:
    """Equations of motion q'' = f(t, q, q') for a step of a scheme."""

    # function of a time, q and q'
    acceleration: Callable[[Any, StateParts, StateParts], StateParts]
    count: int  # number of rates q'
    implicit: Callable[[StateParts], tuple[Any, Any]] | None = None
    """Function from a state to the damping [1/s] and the stiffness [1/s^2] that act on the state
    after a step. Leapfrog takes all damping from here for its implicit half kick; None: leapfrog
    solves the half kick by iteration."""
    drifted: Callable[[StateParts, StateParts, Any], StateParts] = advance_parts
    """Function from q, a constant q' and a step to q after the step."""


def scheme_step(scheme: Scheme, equations: Equations, step: Any) -> SchemeStep:
    """Returns the step of a `scheme` of STEPPED_SCHEMES on the `equations`; `step` is its size
    [s]."""
    held_fraction = READ_AT.get(scheme.control)

    def acceleration(time: Any, fraction: float, q: StateParts, v: StateParts) -> StateParts:
        """Returns q'' with the control that the scheme reads at a `fraction` of the step."""
        read_at = fraction if held_fraction is None else held_fraction
        return equations.acceleration(time + step * read_at, q, v)

    tableau = TABLEAUX.get(scheme.integrator)
    if tableau is not None:
        return _explicit_step(tableau, equations.count, acceleration, step)
    if scheme.position_first:
        return _position_first_step(equations, acceleration, step)
    if scheme.integrator == EULER:
        return _euler_step(equations, acceleration, step)
    return _leapfrog_step(equations, acceleration, step)


def _explicit_step(
    tableau: Tableau, count: int, acceleration: StageAcceleration, step: Any
) -> SchemeStep:
    """Returns the step of an explicit Runge-Kutta method; `count` is the number of rates q'."""

    def explicit_step(time: Any, state: StateParts) -> StateParts:
        """Returns the state after a step."""

        def slopes(fraction: float, z: StateParts) -> StateParts:
            """Returns q' and q'' in the state z, at a `fraction` of the step."""
            v = z[-count:]
            return [*v, *acceleration(time, fraction, z[:-count], v)]

        return tableau.advanced(slopes, state, step)

    return explicit_step


def _position_first_step(
    equations: Equations, acceleration: StageAcceleration, step: Any
) -> SchemeStep:
    """Returns the step that moves q with the old rates, then changes the rates."""
    count = equations.count
    drifted = equations.drifted

    def position_first_step(time: Any, state: StateParts) -> StateParts:
        """Returns the state after a step."""
        v = state[-count:]
        q = drifted(state[:-count], v, step)
        return [*q, *advance_parts(v, acceleration(time, 0.0, q, v), step)]

    return position_first_step


def _euler_step(equations: Equations, acceleration: StageAcceleration, step: Any) -> SchemeStep:
    """Returns the step of semi-implicit Euler, with its implicit damping and spring."""
    count = equations.count
    drifted = equations.drifted
    implicit = equations.implicit

    def euler_step(time: Any, state: StateParts) -> StateParts:
        """Returns the state after a step."""
        q = state[:-count]
        v = state[-count:]
        push = acceleration(time, 0.0, q, v)
        length = step
        if implicit is not None:
            damping, spring = implicit(state)
            push = advance_parts(push, v, -step * spring)
            length = step / (1.0 + step * (damping + step * spring))
        v = advance_parts(v, push, length)
        return [*drifted(q, v, step), *v]

    return euler_step


def _leapfrog_step(
    equations: Equations, acceleration: StageAcceleration, step: Any
) -> SchemeStep:
    """Returns the step of half a kick, a drift, and half a kick by the accelerations after the
    drift. All damping in the second half kick is implicit."""
    count = equations.count
    drifted = equations.drifted
    implicit = equations.implicit

    def leapfrog_step(time: Any, state: StateParts) -> StateParts:
        """Returns the state after a step."""
        half = step / 2
        q = state[:-count]
        v = state[-count:]
        v = advance_parts(v, acceleration(time, 0.0, q, v), half)
        q = drifted(q, v, step)
        if implicit is not None:
            damping = implicit(state)[0]
            kicked = advance_parts(v, acceleration(time, 1.0, q, [0.0] * count), half)
            return [*q, *[x / (1.0 + half * damping) for x in kicked]]

        def kick(rates: StateParts) -> StateParts:
            """Returns the rates after the second half kick by the accelerations at `rates`."""
            return advance_parts(v, acceleration(time, 1.0, q, rates), half)

        return [*q, *_fixed_point(kick, v)]

    return leapfrog_step


def _fixed_point(kick: Callable[[StateParts], StateParts], start: StateParts) -> StateParts:
    """Returns the rates r that satisfy r = `kick`(r), by a fixed-point iteration from `start`."""
    if isinstance(start[0], Series):
        # Each iteration makes one more term exact.
        return reduce(lambda rates, _: kick(rates), start[0].terms, start)
    if isinstance(start[0], float):
        return _fixed_point_of_numbers(kick, start)
    return _fixed_point_of_arrays(kick, np.array(start))


def _fixed_point_of_numbers(
    kick: Callable[[StateParts], StateParts], rates: StateParts
) -> StateParts:
    """Returns the fixed point of `kick` near numbers `rates`. The iteration ends when its changes
    no longer shrink."""
    previous_change = math.inf
    for _ in range(MAX_HALF_KICK_ITERATIONS):
        kicked = kick(rates)
        changes = [abs(after - rate) for after, rate in zip(kicked, rates, strict=True)]
        change = max(changes)
        rates = kicked
        if not 0.0 < change < previous_change:
            break
        previous_change = change
    return rates


def _fixed_point_of_arrays(kick: Callable[[StateParts], StateParts], rates: Any) -> StateParts:
    """Returns the fixed points of `kick` near `rates`, shape (count, n). Each of the n iterations
    ends when its changes no longer shrink."""
    previous_change: Any = math.inf
    shrinks = np.ones(rates.shape[1:], dtype=bool)
    for _ in range(MAX_HALF_KICK_ITERATIONS):
        kicked = np.array(kick(rates))
        change = np.abs(kicked - rates).max(axis=0)
        rates = np.where(shrinks, kicked, rates)
        shrinks &= (change > 0.0) & (change < previous_change)
        if not shrinks.any():
            break
        previous_change = change
    return [*rates]


def whole_steps(times: Array, step: float) -> npt.NDArray[Any]:
    """Returns the numbers of steps of `step` [s] nearest to `times` [s], shape (n,)."""
    return np.rint(np.asarray(times) / step).astype(np.int64)


def steps_until(times: Array, step: float, most: int = MAX_SCHEME_STEPS) -> StepNumbers | None:
    """Returns the numbers of steps of `step` [s] up to `times` [s], shape (n,).

    Returns None for more than `most` steps, and for times that are no multiples of the step.
    """
    marks = whole_steps(times, step)
    if not 0 < int(marks[-1]) <= most:
        return None
    largest_offset = np.abs(times / step - marks).max()
    return marks if largest_offset <= LARGEST_OFFSET + ULP * marks[-1] else None


def states_after(
    advance: SchemeStep,
    state: StateParts,
    step: float,
    marks: Sequence[int],
    steps_taken: int = 0,
) -> list[StateParts]:
    """Returns the states after each of the increasing numbers of steps `marks` of `step` [s].

    `state` is the state after `steps_taken` steps.
    """
    states = []
    for mark in marks:
        for n in range(steps_taken, mark):
            state = advance(n * step, state)
        states.append(state)
        steps_taken = mark
    return states
