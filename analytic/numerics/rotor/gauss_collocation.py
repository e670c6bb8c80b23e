"""The driven rotor's motion by Gauss collocation of order 24: the second, independent method.

It uses the equation only through its acceleration, no series and no recurrences, and chooses its
own steps, so that an error in the Taylor series shows as a disagreement. Round-off is kept small as
in Hairer, McLachlan and Razakarivony 2008 (BIT 48, 231): iterate to stagnation, sum with
compensation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.arithmetic import CompensatedState, two_product, two_sum
from plumbob.analytic.numerics.collocation import gauss_collocation
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.parameters import ParameterError, finite, positive
from plumbob.analytic.reference import Array

STAGES = 12
ITERATIONS = 40
TURN, TURN_LOW = math.tau, 2.4492935982947064e-16  # their sum is 2 pi to 107 bits
CANCELLED = 1e-15  # round-off of a damping force that another force all but cancels, relative
RESOLVED = 1e-9  # of the last Legendre coefficients: their square, the step's error, is below 1e-17


@dataclass(frozen=True)
class Nodes:
    """A motion at the ends of its steps."""

    times: Array  # [s], shape (steps + 1,)
    theta: Array  # [rad], shape (steps + 1,)
    theta_dot: Array  # [rad/s], shape (steps + 1,)


def integrate(rotor: DrivenRotor, theta: float, theta_dot: float, duration: float) -> Nodes:
    """Motion of `rotor` from `theta` [rad], `theta_dot` [rad/s] for `duration` [s], at the ends of
    steps that the method chooses. Raises ParameterError."""
    state = CompensatedState(finite("theta", theta), finite("theta_dot", theta_dot))
    positive("duration", duration)
    rule = gauss_collocation(STAGES)
    second_moments = rule.weights * (1 - rule.nodes)
    largest = 2.0 ** math.floor(math.log2(duration))
    rate = max(rotor.rate(state.rate), 1.0 / duration)
    step = min(largest, 2.0 ** math.floor(math.log2(1.0 / rate)))
    time, turns = 0.0, 0
    rows = [(time, state.position, state.rate)]
    while time < duration:
        if step < largest * 2.0**-20:
            raise ParameterError(
                "duration", duration, f"shorter: the motion at {time} s is too fast"
            )
        used = min(step, duration - time)
        a, resolution = _stages(rotor, time, state, used)
        if resolution > RESOLVED:
            step /= 2
            continue
        gain = used * used * float(second_moments @ a)
        state = state.advanced(used, gain, used * float(rule.weights @ a))
        time += used
        if rotor.stiffness == 0.0 and abs(state.position) > math.pi:
            # A periodic potential does not count turns, and a small angle has smaller round-off.
            sign = int(math.copysign(1, state.position))
            turns += sign
            state = state.shifted(-sign * TURN, -sign * TURN_LOW)
        rows.append((time, _unwound(state, turns), state.rate))
        if resolution < RESOLVED**1.5 and used == step and time % (2 * step) == 0.0:
            step = min(2 * step, largest)
    return Nodes(*np.array(rows).T)


def _unwound(state: CompensatedState, turns: int) -> float:
    """The angle [rad] with its whole `turns`."""
    turned, low = two_product(float(turns), TURN)
    total, carry = two_sum(turned, state.position)
    return total + (carry + low + turns * TURN_LOW + state.position_low)


def _stages(
    rotor: DrivenRotor, time: float, state: CompensatedState, step: float
) -> tuple[Array, float]:
    """Accelerations at the nodes by fixed-point iteration, shape (STAGES,), and the relative size
    of their last Legendre coefficients beyond round-off; infinite where that does not converge."""
    rule = gauss_collocation(STAGES)
    once = step * rule.integral
    twice = once @ once
    times = time + step * rule.nodes
    lost = CANCELLED * rotor.damping_rate * abs(state.rate)
    straight = state.position + step * rule.nodes * state.rate
    a, change = rotor.acceleration(times, straight, np.full(STAGES, state.rate)), math.inf
    for _ in range(ITERATIONS):
        again = rotor.acceleration(times, straight + twice @ a, state.rate + once @ a)
        before, change = change, float(np.abs(again - a).max())
        a = again
        if change == 0.0 or (change >= before and change < 1e-14 * np.abs(a).max() + lost):
            break
    else:
        return a, math.inf
    spectrum = np.abs(rule.spectrum @ a)
    return a, float(max(spectrum[-2:].max() - lost, 0.0) / max(spectrum.max(), 1e-300))
