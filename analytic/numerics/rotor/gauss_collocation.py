"""The driven rotor's motion by Gauss collocation of order 24: the second, independent method.

It knows the equation only by its acceleration, has no series and no recurrences, and its steps are
its own, so that an error in the Taylor series cannot hide in it. Round-off is held down as in
Hairer, McLachlan and Razakarivony 2008 (BIT 48, 231): iterate to stagnation, sum with compensation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.collocation import gauss_collocation
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rounding import two_product, two_sum
from plumbob.analytic.parameters import ParameterError, finite, positive
from plumbob.analytic.reference import Array

STAGES = 12
ITERATIONS = 40
TURN, TURN_LOW = math.tau, 2.4492935982947064e-16  # their sum is 2 pi to 107 bits
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
    x, v = finite("theta", theta), finite("theta_dot", theta_dot)
    positive("duration", duration)
    rule = gauss_collocation(STAGES)
    gain = rule.weights * (1 - rule.nodes)
    x_low = v_low = time = 0.0
    largest = 2.0 ** math.floor(math.log2(duration))
    smallest = largest * 2.0**-20
    step = min(largest, 2.0 ** math.floor(math.log2(1.0 / max(rotor.rate(v), 1.0 / duration))))
    states, turns = [(time, x, v)], 0
    while time < duration:
        if step < smallest:
            raise ParameterError(
                "duration", duration, f"shorter: the motion at {time} s is too fast"
            )
        used = min(step, duration - time)
        a, resolution = _stages(rotor, time, x, v, used)
        if resolution > RESOLVED:
            step /= 2
            continue
        drift, drift_low = two_product(v, used)
        pull = used * used * float(gain @ a)
        x, carry = two_sum(x, drift)
        x, x_low = two_sum(x, carry + drift_low + x_low + v_low * used + pull)
        v, carry = two_sum(v, used * float(rule.weights @ a))
        v, v_low = two_sum(v, carry + v_low)
        time += used
        if rotor.stiffness == 0.0 and abs(x) > math.pi:
            # a periodic potential does not count turns, and a small angle rounds finely
            sign = int(math.copysign(1, x))
            turns += sign
            x, carry = two_sum(x, -sign * TURN)
            x, x_low = two_sum(x, carry + x_low - sign * TURN_LOW)
        states.append((time, _unwound(x, x_low, turns), v))
        if resolution < RESOLVED**1.5 and used == step and time % (2 * step) == 0.0:
            step = min(2 * step, largest)
    return Nodes(*np.array(states).T)


def _unwound(x: float, x_low: float, turns: int) -> float:
    whole, low = two_product(float(turns), TURN)
    total, carry = two_sum(whole, x)
    return total + (carry + low + turns * TURN_LOW + x_low)


def _stages(
    rotor: DrivenRotor, time: float, x: float, v: float, step: float
) -> tuple[Array, float]:
    """Accelerations at the nodes by fixed-point iteration, and the share of their last Legendre
    coefficients; infinite when the iteration does not settle."""
    rule = gauss_collocation(STAGES)
    once = step * rule.integral
    twice = once @ once
    times = time + step * rule.nodes
    straight = x + step * rule.nodes * v
    a, change = rotor.acceleration(times, straight, np.full(STAGES, v)), math.inf
    for _ in range(ITERATIONS):
        again = rotor.acceleration(times, straight + twice @ a, v + once @ a)
        before, change = change, float(np.abs(again - a).max())
        a = again
        if change == 0.0 or (change >= before and change < 1e-14 * np.abs(a).max()):
            break
    else:
        return a, math.inf
    spectrum = np.abs(rule.spectrum @ a)
    return a, float(spectrum[-2:].max() / max(spectrum.max(), 1e-300))
