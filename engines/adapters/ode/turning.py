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
    f, velocity, (x, v) = equation.acceleration, equation.velocity, state
    half, sixth = 0.5 * h, h / 6
    for n in range(first, last):
        t = n * h
        a1, u1 = f(t, x, v), velocity(x, v)
        x2, v2 = _moved(x, half, u1), _moved(v, half, a1)
        a2, u2 = f(t + half, x2, v2), velocity(x2, v2)
        x3, v3 = _moved(x, half, u2), _moved(v, half, a2)
        a3, u3 = f(t + half, x3, v3), velocity(x3, v3)
        x4, v4 = _moved(x, h, u3), _moved(v, h, a3)
        a4, u4 = f(t + h, x4, v4), velocity(x4, v4)
        x = [
            p + sixth * (a + 2 * (b + c) + d)
            for p, a, b, c, d in zip(x, u1, u2, u3, u4, strict=True)
        ]
        v = [
            p + sixth * (a + 2 * (b + c) + d)
            for p, a, b, c, d in zip(v, a1, a2, a3, a4, strict=True)
        ]
    return x, v


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
