"""Steps of schemes on a joint under a held torque: their errors, and the limits of their loops.

Eq. 2 of `analytic/systems/held_loop.py` is linear, so a step of a scheme is a matrix for the state
and a vector for the torque. Both follow from the scheme's own step on three unit vectors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from plumbob.analytic.errors.smooth_motion.scheme_steps import StateParts, steps_until
from plumbob.analytic.errors.smooth_motion.stepped_system import MAX_SYSTEM_STEPS, system_step
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.sampled_control import AT_BEGIN, HeldAnswers
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.stability import LoopQuantity
from plumbob.analytic.systems.held_loop import (
    LOOP_OBSERVABLES,
    MOST_DELAY,
    Flow,
    HeldLoop,
    first_unstable,
    loop_multiplier,
    repeated_flow,
)
from plumbob.analytic.theory import StepErrors, signal_differences


def scheme_flow(loop: HeldLoop, scheme: Scheme, step: float) -> Flow | None:
    """Returns the motion over a step [s] of `scheme` under a constant torque; None for schemes that
    are not stepped here.

    The columns of its matrix are the steps from three unit vectors: of the angle, the rate and the
    torque.
    """
    slowing = loop.damping / loop.inertia

    def implicit(stepped: Scheme, state: StateParts) -> tuple[float, float]:
        """Returns the damping [1/s] that the scheme treats implicitly, and no stiffness."""
        return float(stepped.implicit_damping) * slowing, 0.0

    columns: list[Sequence[float]] = []
    for state, torque in (([1.0, 0.0], 0.0), ([0.0, 1.0], 0.0), ([0.0, 0.0], 1.0)):
        advance = system_step(scheme, _plant(loop, torque), step, implicit)
        if advance is None:
            return None
        columns.append(advance(0.0, state))
    matrix = np.array(columns, dtype=float).T
    return matrix[:, :2], matrix[:, 2]


def _plant(loop: HeldLoop, torque: float) -> SmoothSystem:
    """Returns the joint under a constant torque [N m]."""
    return SmoothSystem(
        coordinates=LOOP_OBSERVABLES[:1],
        rates=LOOP_OBSERVABLES[1:],
        mass_matrix=lambda p, q: ((loop.inertia,),),
        forces=lambda p, time, q, v: (torque - loop.damping * v[0],),
        parameters={},
        position=(0.0,),
        rate=(0.0,),
    )


def held_errors(loop: HeldLoop) -> StepErrors:
    """Returns the errors of schemes on a loop. Steps that do not divide the hold sample at the next
    step, and the errors include that. The errors are empty for schemes that are not stepped here,
    for more than MAX_SYSTEM_STEPS steps, and for times that are no multiples of the step."""

    def error(scheme: Scheme, step: float, times: Array) -> Signals:
        """Returns the errors of angle and rate at `times` [s]."""
        marks = steps_until(times, step, MAX_SYSTEM_STEPS)
        flow = scheme_flow(loop, scheme, step)
        if marks is None or flow is None:
            return {}
        with np.errstate(all="ignore"):  # a loop that is unstable may overflow
            states = _stepped_states(loop, flow, step, int(marks[-1]))[:, marks]
        if not np.isfinite(states).all():
            return {}
        return signal_differences(
            dict(zip(LOOP_OBSERVABLES, states, strict=True)), loop.observe(times)
        )

    return StepErrors(error)


def _stepped_states(loop: HeldLoop, flow: Flow, step: float, steps: int) -> Array:
    """Returns the states at the start and after each of `steps` steps, shape (2, steps + 1)."""
    (to_x, to_v), (x_torque, v_torque) = flow[0].tolist(), flow[1].tolist()
    stiffness, rate_gain = loop.gains.tolist()
    state = loop.theta, loop.theta_dot
    states = [state]

    def torque(time: float) -> float:
        """Returns the controller's torque [N m] by the present state."""
        return float(-stiffness * state[0] - rate_gain * state[1])

    for held, count in HeldAnswers(loop.times, step, torque, 0.0).parts(0, steps):
        for _ in range(count):
            x, v = state
            state = (
                to_x[0] * x + to_x[1] * v + x_torque * held,
                to_v[0] * x + to_v[1] * v + v_torque * held,
            )
            states.append(state)
    return np.array(states).T


def steps_of(duration: float, step: float) -> int | None:
    """Returns the number of steps [s] in a duration [s]; None if the step does not divide it."""
    count = round(duration / step)
    return count if abs(duration / step - count) <= AT_BEGIN else None


def scheme_limit(
    loop: HeldLoop, scheme: Scheme, quantity: LoopQuantity, step: float
) -> float | None:
    """Returns the hold [s], the delay [s] or the factor of both gains up to which the loop under
    steps of `scheme` is stable, like `HeldLoop.limit`.

    A hold that changes keeps its number of steps [s]; a delay that changes is a multiple of the
    step. The result is None for schemes that are not stepped here, and for steps that do not divide
    the hold and the delay.
    """
    steps_in_hold = steps_of(loop.hold, step)
    steps_in_delay = steps_of(loop.delay, step)
    flow = scheme_flow(loop, scheme, step)
    if not steps_in_hold or steps_in_delay is None or flow is None:
        return None
    if quantity == "delay":
        last_stable = None
        for count in range(MOST_DELAY * steps_in_hold):
            if _is_stable(loop, flow, steps_in_hold, count):
                last_stable = count
            elif last_stable is not None:
                return last_stable * step
        return 0.0 if last_stable is None else math.inf

    def is_stable_at(value: float) -> bool:
        """Whether the loop is stable with another hold or other gains."""
        changed_loop = loop.changed(quantity, value)
        changed_flow = scheme_flow(changed_loop, scheme, changed_loop.hold / steps_in_hold)
        assert changed_flow is not None
        return _is_stable(changed_loop, changed_flow, steps_in_hold, steps_in_delay)

    return first_unstable(is_stable_at, loop.scan(quantity))


def _is_stable(loop: HeldLoop, flow: Flow, steps_in_hold: int, steps_in_delay: int) -> bool:
    """Returns whether a loop is stable under steps with this `flow`."""
    holds_in_delay, steps_before_switch = divmod(steps_in_delay, steps_in_hold)
    early = repeated_flow(flow, steps_before_switch)
    late = repeated_flow(flow, steps_in_hold - steps_before_switch)
    return loop_multiplier(early, late, loop.gains, holds_in_delay) < 1.0
