"""One step of each scheme on q'' = f(t, q, q'), for numbers, arrays or power series in the step."""

from __future__ import annotations

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
from plumbob.analytic.tableau import moved

MOST_STEPS = 2_000_000  # steps in a run, which take a few seconds
OFF = 1e-6  # [steps] a sample further from a whole number of steps is not on the orbit
MOST_CORRECTIONS = 100  # iterations for an implicit half kick
READ_AT = MappingProxyType({"start": 0.0, "midpoint": 0.5, "mean": 0.5})
"""Fraction of a step at which a held control is read, by kind of control."""
Marks = npt.NDArray[np.int64]
Parts = Sequence[Any]
Advance = Callable[[Any, Parts], Parts]
"""Function from the time [s] and state at a step's start to the state after it: q and then q'."""


@dataclass(frozen=True)
class Equations:
    """Equations of motion q'' = f(t, q, q') for a step of a scheme."""

    acceleration: Callable[[Any, Parts, Parts], Parts]  # function of a time, q and q'
    count: int  # number of rates q'
    implicit: Callable[[Parts], tuple[Any, Any]] | None = None
    """Function from a state to the damping [1/s] and the stiffness [1/s^2] that act on the state
    after a step. Leapfrog takes all damping from here for its implicit half kick; None: leapfrog
    solves the half kick by iteration."""
    drifted: Callable[[Parts, Parts, Any], Parts] = moved
    """Function from q, a constant q' and a step to q after the step."""


def scheme_step(scheme: Scheme, equations: Equations, step: Any) -> Advance:
    """Returns the step of a `scheme` of STEPPED on the `equations`; `step` is its size [s]."""
    count = equations.count
    drifted = equations.drifted
    implicit = equations.implicit
    tableau = TABLEAUX.get(scheme.integrator)
    held_fraction = READ_AT.get(scheme.control)

    def acceleration(time: Any, fraction: float, q: Parts, v: Parts) -> Parts:
        read_at = fraction if held_fraction is None else held_fraction
        return equations.acceleration(time + step * read_at, q, v)

    def explicit_step(time: Any, state: Parts) -> Parts:
        assert tableau is not None

        def slopes(fraction: float, z: Parts) -> Parts:
            v = z[-count:]
            return [*v, *acceleration(time, fraction, z[:-count], v)]

        return tableau.advanced(slopes, state, step)

    def position_first_step(time: Any, state: Parts) -> Parts:
        v = state[-count:]
        q = drifted(state[:-count], v, step)
        return [*q, *moved(v, acceleration(time, 0.0, q, v), step)]

    def euler_step(time: Any, state: Parts) -> Parts:
        q = state[:-count]
        v = state[-count:]
        push = acceleration(time, 0.0, q, v)
        length = step
        if implicit is not None:
            damping, spring = implicit(state)
            push = moved(push, v, -step * spring)
            length = step / (1.0 + step * (damping + step * spring))
        v = moved(v, push, length)
        return [*drifted(q, v, step), *v]

    def leapfrog_step(time: Any, state: Parts) -> Parts:
        # Half a kick, a drift, and half a kick by the accelerations after the drift.
        half = step / 2
        q = state[:-count]
        v = state[-count:]
        v = moved(v, acceleration(time, 0.0, q, v), half)
        q = drifted(q, v, step)
        if implicit is not None:
            damping = implicit(state)[0]
            kicked = moved(v, acceleration(time, 1.0, q, [0.0] * count), half)
            return [*q, *[x / (1.0 + half * damping) for x in kicked]]

        def kick(rates: Parts) -> Parts:
            return moved(v, acceleration(time, 1.0, q, rates), half)

        return [*q, *_fixed_point(kick, v)]

    if tableau is not None:
        return explicit_step
    if scheme.position_first:
        return position_first_step
    return euler_step if scheme.integrator == EULER else leapfrog_step


def _fixed_point(kick: Callable[[Parts], Parts], start: Parts) -> Parts:
    """Returns the rates r that satisfy r = `kick`(r), by a fixed-point iteration from `start`.

    The iteration ends when its changes no longer shrink. Each iteration makes one more term of a
    power series exact: series take as many iterations as they have terms.
    """
    if isinstance(start[0], Series):
        return reduce(lambda rates, _: kick(rates), start[0].terms, start)
    before: Any = np.inf
    if isinstance(start[0], float):
        for _ in range(MOST_CORRECTIONS):
            rates = start
            start = kick(start)
            changes = [abs(after - rate) for after, rate in zip(start, rates, strict=True)]
            change = max(changes)
            if not 0.0 < change < before:
                break
            before = change
        return start
    rates_now: Any = np.array(start)
    shrinks = np.ones(rates_now.shape[1:], dtype=bool)
    for _ in range(MOST_CORRECTIONS):
        kicked = np.array(kick(rates_now))
        change = np.abs(kicked - rates_now).max(axis=0)
        rates_now = np.where(shrinks, kicked, rates_now)
        shrinks &= (change > 0.0) & (change < before)
        if not shrinks.any():
            break
        before = change
    return [*rates_now]


def whole_steps(times: Array, step: float) -> npt.NDArray[Any]:
    """Returns the numbers of steps of `step` [s] nearest to `times` [s], shape (n,)."""
    return np.rint(np.asarray(times) / step).astype(np.int64)


def steps_until(times: Array, step: float, most: int = MOST_STEPS) -> Marks | None:
    """Returns the numbers of steps of `step` [s] up to `times` [s], shape (n,).

    Returns None for more than `most` steps, and for times that are no multiples of the step.
    """
    marks = whole_steps(times, step)
    if not 0 < int(marks[-1]) <= most:
        return None
    largest_offset = np.abs(times / step - marks).max()
    return marks if largest_offset <= OFF + ULP * marks[-1] else None


def states_after(
    advance: Advance, state: Parts, step: float, marks: Sequence[int]
) -> list[Parts]:
    """Returns the states after each of the increasing numbers of steps `marks` of `step` [s]."""
    states = []
    steps_taken = 0
    for mark in marks:
        for n in range(steps_taken, mark):
            state = advance(n * step, state)
        states.append(state)
        steps_taken = mark
    return states
