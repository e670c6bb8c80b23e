"""Fixed-step integrators of theta'' = f(t, theta, theta_dot): semi-implicit Euler, leapfrog, RK4.

Plain floats in tight loops: an array of two numbers would cost more than the arithmetic on it.
"""

from __future__ import annotations

from collections.abc import Callable

from plumbob.analytic.errors.schemes import EULER, LEAPFROG, RK4
from plumbob.engines.adapters.ode.equation import Equation

State = tuple[float, float]  # theta [rad], theta_dot [rad/s]
Advance = Callable[[Equation, State, int, int, float], State]


def semi_implicit_euler(equation: Equation, state: State, first: int, last: int, h: float) -> State:
    """State after the steps `first` to `last` - 1 of length `h` [s]: v = v + h f(t, theta, v),
    then theta = theta + h v."""
    f, (theta, v) = equation.acceleration, state
    for n in range(first, last):
        v += h * f(n * h, theta, v)
        theta += h * v
    return theta, v


def leapfrog(equation: Equation, state: State, first: int, last: int, h: float) -> State:
    """State after the steps `first` to `last` - 1 of length `h` [s]: kick half a step, drift, kick
    half a step, the damping explicit in the first kick and implicit in the second."""
    f, (theta, v) = equation.acceleration, state
    half, damping = 0.5 * h, equation.damping_rate
    # What 1/(1 + damping h/2) takes away: that factor itself, rounded, would err alike every step.
    taken = half * damping / (1 + half * damping)
    force = f(first * h, theta, 0.0)
    for n in range(first, last):
        v += half * (force - damping * v)
        theta += h * v
        force = f((n + 1) * h, theta, 0.0)
        v += half * force
        v -= taken * v
    return theta, v


def rk4(equation: Equation, state: State, first: int, last: int, h: float) -> State:
    """State after the steps `first` to `last` - 1 of length `h` [s] of the classical Runge-Kutta
    method, as the notebook takes it (Pendulo Simples)."""
    f, (theta, v) = equation.acceleration, state
    half, sixth = 0.5 * h, h / 6
    for n in range(first, last):
        t = n * h
        a1 = f(t, theta, v)
        v2 = v + half * a1
        a2 = f(t + half, theta + half * v, v2)
        v3 = v + half * a2
        a3 = f(t + half, theta + half * v2, v3)
        v4 = v + h * a3
        a4 = f(t + h, theta + h * v3, v4)
        theta += sixth * (v + 2 * (v2 + v3) + v4)
        v += sixth * (a1 + 2 * (a2 + a3) + a4)
    return theta, v


def advance(integrator: str) -> Advance:
    """The step of an `integrator`: semi-implicit-euler, leapfrog or rk4; raises KeyError."""
    return {EULER: semi_implicit_euler, LEAPFROG: leapfrog, RK4: rk4}[integrator]
