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


def advance(scheme: Scheme, equations: Equations, step: Any) -> Advance:
    """Returns the step of a `scheme` of STEPPED on the `equations`; `step` is its size [s]."""
    count = equations.count
    drifted = equations.drifted
    implicit = equations.implicit
    tableau = TABLEAUX.get(scheme.integrator)
    lag = READ_AT.get(scheme.control)

    def pulled(time: Any, fraction: float, q: Parts, v: Parts) -> Parts:
        return equations.acceleration(time + step * (fraction if lag is None else lag), q, v)

    def stepped(time: Any, state: Parts) -> Parts:
        if tableau is not None:

            def slopes(part: float, z: Parts) -> Parts:
                v = z[-count:]
                return [*v, *pulled(time, part, z[:-count], v)]

            return tableau.advanced(slopes, state, step)
        q = state[:-count]
        v = state[-count:]
        if scheme.position_first:
            q = drifted(q, v, step)
            return [*q, *moved(v, pulled(time, 0.0, q, v), step)]
        push = pulled(time, 0.0, q, v)
        length = step
        damping, spring = (0.0, 0.0) if implicit is None else implicit(state)
        if scheme.integrator == EULER:
            if implicit is not None:
                push = moved(push, v, -step * spring)
                length = step / (1.0 + step * (damping + step * spring))
            v = moved(v, push, length)
            return [*drifted(q, v, step), *v]
        # Leapfrog: half a kick, a drift, and half a kick by the accelerations after the drift.
        half = step / 2
        v = moved(v, push, half)
        q = drifted(q, v, step)
        if implicit is not None:
            kicked = moved(v, pulled(time, 1.0, q, [0.0] * count), half)
            return [*q, *(x / (1.0 + half * damping) for x in kicked)]
        return [*q, *_corrected(lambda rates: moved(v, pulled(time, 1.0, q, rates), half), v)]

    return stepped


def _corrected(kick: Callable[[Parts], Parts], start: Parts) -> Parts:
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
            change = max([abs(x - rate) for x, rate in zip(start, rates, strict=True)])
            if not 0.0 < change < before:
                break
            before = change
        return start
    now: Any = np.array(start)
    shrinks = np.ones(now.shape[1:], dtype=bool)
    for _ in range(MOST_CORRECTIONS):
        after = np.array(kick(now))
        change = np.abs(after - now).max(axis=0)
        now = np.where(shrinks, after, now)
        shrinks &= (change > 0.0) & (change < before)
        if not shrinks.any():
            break
        before = change
    return [*now]


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
    off = np.abs(times / step - marks).max()
    return marks if off <= OFF + ULP * marks[-1] else None


def states_after(
    advance: Advance, state: Parts, step: float, marks: Sequence[int]
) -> list[Parts]:
    """Returns the states after each of the increasing numbers of steps `marks` of `step` [s]."""
    states = []
    done = 0
    for mark in marks:
        for n in range(done, mark):
            state = advance(n * step, state)
        states.append(state)
        done = mark
    return states
