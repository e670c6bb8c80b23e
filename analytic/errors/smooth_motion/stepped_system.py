"""Errors of fixed steps on any smooth system: the scheme stepped, less the certified motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType

import numpy as np

from plumbob.analytic.errors.smooth_motion.rotor_steps import READ_AT
from plumbob.analytic.errors.smooth_motion.stepped_rotor import steps_until
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, LEAPFROG, TABLEAUX, Scheme, SoftLoop
from plumbob.analytic.systems.servo import Servo
from plumbob.analytic.tableau import Tableau
from plumbob.analytic.theory import StepErrors

MOST_STEPS = 200_000  # of a run: some ten seconds
MOST_CORRECTIONS = 100  # of an implicit half step
Slope = Callable[[float, Array], Array]
Implicit = Callable[[Scheme, Array], tuple[float, float]]
"""A scheme and a state -> damping [1/s] and stiffness [1/s^2]."""
Advance = Callable[[Slope, float, Array, float], Array]


def smooth_errors(
    motion: CertifiedMotion | Servo,
    soft: Callable[[SoftLoop, float], SmoothSystem] | None = None,
    implicit: Implicit | None = None,
) -> StepErrors:
    """The errors of semi-implicit Euler, leapfrog and the TABLEAUX on `motion`, or with a loop that
    is closed softly, of which `soft` gives the equations at a step [s], or with what is `implicit`
    of one coordinate; empty for others, for other damping or springs that act on the state after a
    step, for more than MOST_STEPS steps, for times that are no multiples of the step, and where the
    steps diverge."""

    def error(scheme: Scheme, step: float, times: Array) -> Mapping[str, Array]:
        marks, system = steps_until(times, step, MOST_STEPS), motion.system
        if scheme.loop is not None and soft is not None:
            system = soft(scheme.loop, step)
        advance = advance_of(scheme, system)
        if implicit is not None and scheme.integrator == EULER and not scheme.position_first:
            advance = partial(_implicit_euler, partial(implicit, scheme))
        if advance is None or marks is None:
            return {}
        held = READ_AT.get(scheme.control)
        with np.errstate(all="ignore"):  # of steps that diverge
            states = _stepped(system, advance, step, marks.tolist(), held)
        if not np.isfinite(states).all():
            return {}
        exact = motion.observe(times)
        observed = system.observed(states.T)
        return {name: observed[name] - exact[name] for name in exact}

    return StepErrors(error)


def advance_of(scheme: Scheme, system: SmoothSystem) -> Advance | None:
    """The step of `scheme` on `system`, of states of shape (2 n, ...) and steps that broadcast with
    (...); None for others, and where a part of the forces is implicit."""
    jointed = scheme.joint_closing_rate is not None or scheme.control == "mean"
    damped = scheme.implicit_damping > 0.0 and system.damped
    if jointed or scheme.implicit_spring or damped:
        return None
    moves_first = scheme.integrator == EULER and scheme.position_first
    return _position_first if moves_first else _ADVANCES.get(scheme.integrator)


def _stepped(
    system: SmoothSystem, advance: Advance, step: float, marks: list[int], held: float | None
) -> Array:
    """States after the numbers of steps `marks`, shape (n, 2 coordinates); time-dependent forces
    are read at the stages' own times, or `held` at that fraction of each step."""
    values, begin, state = system.values, 0.0, system.start

    def slope(time: float, at: Array) -> Array:
        read = time if held is None else begin + held * step
        q, v = at.reshape(2, -1).tolist()
        return np.array([*v, *system.acceleration(read, q, v, values)])

    states, done = [], 0
    for mark in marks:
        for n in range(done, mark):
            begin = n * step
            state = advance(slope, begin, state, step)
        states.append(state)
        done = mark
    return np.array(states)


def _euler(slope: Slope, time: float, state: Array, step: float) -> Array:
    """The rates first, then the coordinates at the new rates."""
    half = len(state) // 2
    rates = state[half:] + step * slope(time, state)[half:]
    return np.concatenate([state[:half] + step * rates, rates])


def _implicit_euler(
    implicit: Callable[[Array], tuple[float, float]],
    slope: Slope,
    time: float,
    state: Array,
    step: float,
) -> Array:
    """The same of one coordinate with the damping and the spring of the state after the step."""
    damping, spring = implicit(state)
    kick = slope(time, state)[1] - step * spring * state[1]
    rate = state[1] + step * kick / (1.0 + step * (damping + step * spring))
    return np.array([state[0] + step * rate, rate])


def _position_first(slope: Slope, time: float, state: Array, step: float) -> Array:
    """The coordinates first, then the rates at the new coordinates."""
    half = len(state) // 2
    moved = np.concatenate([state[:half] + step * state[half:], state[half:]])
    return np.concatenate([moved[:half], state[half:] + step * slope(time, moved)[half:]])


def _leapfrog(slope: Slope, time: float, state: Array, step: float) -> Array:
    """Half a kick, explicit; a drift; half a kick, implicit, by fixed-point iteration until nothing
    changes or changes no longer shrink."""
    half = len(state) // 2
    kicked = state[half:] + 0.5 * step * slope(time, state)[half:]
    state, change = np.concatenate([state[:half] + step * kicked, kicked]), np.inf
    for _ in range(MOST_CORRECTIONS):
        rates = kicked + 0.5 * step * slope(time + step, state)[half:]
        before, change = change, float(np.abs(rates - state[half:]).max())
        state = np.concatenate([state[:half], rates])
        if not 0.0 < change < before:
            break
    return state


def _explicit(tableau: Tableau) -> Advance:
    def advance(slope: Slope, time: float, state: Array, step: float) -> Array:
        return np.asarray(state + tableau.change(slope, time, state, step))

    return advance


_ADVANCES: Mapping[str, Advance] = MappingProxyType(
    {EULER: _euler, LEAPFROG: _leapfrog}
    | {name: _explicit(tableau) for name, tableau in TABLEAUX.items()}
)
