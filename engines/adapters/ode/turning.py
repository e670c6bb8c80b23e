"""Equations of motion of a body's attitude, and their integrators: x' = x v/2 as quaternions, with
the angular velocity v in the body's axes.

Plain floats: arrays of three and four numbers would cost more than the arithmetic on them. Euler
and leapfrog turn the body by the angular velocity of the step, exactly; RK4 takes the quaternion as
four numbers like any others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from plumbob.analytic.schemes import EULER, LEAPFROG, RK4
from plumbob.engines.adapters.ode.equation import Equation, State
from plumbob.engines.adapters.ode.integrators import MOST_CORRECTIONS

Quaternion = Sequence[float]
Vector = Sequence[float]


class Turning(Equation):
    """An `Equation` whose position is a quaternion and whose rate is an angular velocity; its
    acceleration maps time, position and rate to a sequence of three floats."""

    def velocity(self, attitude: Quaternion, rate: Vector) -> Quaternion:
        """Rate of the quaternion [1/s] at the angular velocity `rate` [rad/s]."""
        return _product(attitude, [0.0, *(0.5 * part for part in rate)])


def turned(attitude: Quaternion, rate: Vector, h: float) -> Quaternion:
    """The attitude after the time `h` [s] at a constant `rate` [rad/s]."""
    x, y, z = rate
    speed = math.sqrt(x * x + y * y + z * z)
    half = 0.5 * h * speed
    ratio = math.sin(half) / speed if speed else 0.0
    return _product(attitude, [math.cos(half), ratio * x, ratio * y, ratio * z])


def semi_implicit_euler(equation: Equation, state: State, first: int, last: int, h: float) -> State:
    """State after the steps `first` to `last` - 1 of length `h` [s]: the rate first, then a turn at
    the new rate."""
    f, (x, v) = equation.acceleration, state
    for n in range(first, last):
        v = _moved(v, h, f(n * h, x, v))
        x = turned(x, v, h)
    return x, v


def leapfrog(equation: Equation, state: State, first: int, last: int, h: float) -> State:
    """The same with half a kick, explicit; a turn; half a kick, implicit, by fixed-point iteration
    until nothing changes or changes no longer shrink."""
    f, (x, v) = equation.acceleration, state
    half = 0.5 * h
    for n in range(first, last):
        v = middle = _moved(v, half, f(n * h, x, v))
        x = turned(x, v, h)
        change = math.inf
        for _ in range(MOST_CORRECTIONS):
            corrected = _moved(middle, half, f((n + 1) * h, x, v))
            before = change
            change = max(abs(a - b) for a, b in zip(corrected, v, strict=True))
            v = corrected
            if not 0.0 < change < before:
                break
    return x, v


def rk4(equation: Equation, state: State, first: int, last: int, h: float) -> State:
    """The same of the classical Runge-Kutta method, for quaternion and rate together."""
    assert isinstance(equation, Turning)
    half = 0.5 * h
    for n in range(first, last):
        t = n * h
        k1 = _slopes(equation, t, state)
        k2 = _slopes(equation, t + half, _both_moved(state, half, k1))
        k3 = _slopes(equation, t + half, _both_moved(state, half, k2))
        k4 = _slopes(equation, t + h, _both_moved(state, h, k3))
        x, v = (_weighted(h / 6, *parts) for parts in zip(state, k1, k2, k3, k4, strict=True))
        state = x, v
    return state


def _slopes(equation: Turning, time: float, state: State) -> State:
    x, v = state
    return equation.velocity(x, v), equation.acceleration(time, x, v)


def _both_moved(state: State, time: float, slopes: State) -> State:
    return _moved(state[0], time, slopes[0]), _moved(state[1], time, slopes[1])


def _weighted(sixth: float, start: Vector, *slopes: Vector) -> Vector:
    return [p + sixth * (a + 2 * (b + c) + d) for p, a, b, c, d in zip(start, *slopes, strict=True)]


def turning_integrator(name: str) -> Callable[[Equation, State, int, int, float], State]:
    """The integrator that a `Scheme` names: EULER, LEAPFROG or RK4; raises KeyError."""
    return {EULER: semi_implicit_euler, LEAPFROG: leapfrog, RK4: rk4}[name]


def _moved(start: Sequence[float], length: float, slope: Sequence[float]) -> list[float]:
    return [a + length * b for a, b in zip(start, slope, strict=True)]


def _product(p: Quaternion, q: Quaternion) -> list[Any]:
    """Hamilton's product."""
    a, b, c, d = p
    w, x, y, z = q
    return [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
