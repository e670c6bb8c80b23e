"""The derivative of a stepper's step by its state, and the fixed point of a step."""

from __future__ import annotations

import math
import time

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.method import Unsupported
from plumbob.engines.own_motion import OUT_OF_TIME, NotCertifiable
from plumbob.engines.stepper import Stepper
from plumbob.engines.tangent_space import TangentSpace, state_row
from plumbob.models.border import Refused, border

# A later difference of a Jacobian takes at least a tenth of the time of the first.
FASTER = 10.0
RESTING_STATE_CHANGE = 1e-9  # [m, rad, m/s, ...] largest change of a state at rest in a step
DIFFERENCE = 1e-7  # [m, rad, ...] difference of the Jacobians that find a state at rest
# Stiffness, relative to the stiffest direction, below which a direction has no place of rest
NEUTRAL = 1e-7


def check_time(ends: float, least: float = 0.0) -> None:
    """Raises NotCertifiable if the processor time `ends` [s] is past, or will be after work that
    takes `least` seconds more."""
    if time.process_time() + least > ends:
        raise NotCertifiable(OUT_OF_TIME)


def state_after_step(
    stepper: Stepper, space: TangentSpace, state: Array, control: Array
) -> Array:
    """Returns the state after one step from a `state` under a `control`; NaN if the engine's
    numbers break down."""
    try:
        with border(Refused, Unsupported, ParameterError, NotCertifiable):
            stepper.put(space.state_of(state))
            stepper.advance(control[None], 1)
            return state_row(stepper.state())
    except Refused:
        return np.full(state.size, math.nan)


def step_jacobian(
    stepper: Stepper,
    space: TangentSpace,
    state: Array,
    control: Array,
    difference: float,
    directions: Array | None = None,
    ends: float = math.inf,
) -> Array:
    """Returns the derivative of the state after one step by the state before it, in the tangent
    space, shape (m, m); times `directions`, shape (m, k), if given. It uses central differences of
    a size [m, rad, ...]. Raises NotCertifiable from the processor time `ends` [s] on, and after the
    first difference if all differences would end far beyond it."""
    begin = time.process_time()
    wanted = np.eye(space.size(state)) if directions is None else directions.T
    shifts = difference * wanted
    sides = (space.shifted(state, shifts), space.shifted(state, -shifts))
    ahead = list[Array]()
    behind = list[Array]()
    for forward, backward in zip(*sides, strict=True):
        check_time(ends)
        ahead.append(state_after_step(stepper, space, forward, control))
        check_time(ends)
        behind.append(state_after_step(stepper, space, backward, control))
        if len(ahead) == 1:
            further_differences = len(shifts) - 1
            check_time(ends, further_differences * (time.process_time() - begin) / FASTER)
    return space.differences(np.array(ahead), np.array(behind)).T / (2.0 * difference)


def state_at_rest(
    stepper: Stepper, space: TangentSpace, state: Array, control: Array, ends: float = math.inf
) -> Array | None:
    """Returns a nearby fixed point of one step under a `control`, stable or not, by Newton's
    method; None if the method finds none. A body that nothing holds may rest anywhere. Raises
    NotCertifiable from the processor time `ends` [s] on."""
    before = math.inf
    while True:
        check_time(ends)
        moved = space.differences(state_after_step(stepper, space, state, control), state)
        size = float(np.abs(moved).max())
        if not size < before:
            return None
        if size < RESTING_STATE_CHANGE:
            return state
        step = step_jacobian(stepper, space, state, control, DIFFERENCE, ends=ends)
        free = np.eye(len(step)) - step
        if not np.isfinite(free).all():
            return None
        shift = np.asarray(np.linalg.lstsq(free, moved, NEUTRAL)[0], float)
        before = size
        state = space.shifted(state, shift)
