"""Fixed-step integrators of x'' = f(t, x, x'): semi-implicit Euler, leapfrog, RK4, tableaux.

Plain floats in tight loops where there is one coordinate: an array of two numbers would cost more
than the arithmetic on it. The same code takes arrays where there are several.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from plumbob.analytic.schemes import EULER, LEAPFROG, RK4, TABLEAUX
from plumbob.analytic.tableau import Tableau
from plumbob.engines.adapters.equation import Equation, State
from plumbob.engines.adapters.stepping import Built, SteppedSimulation
from plumbob.engines.sampling import step_count

Advance = Callable[[Equation, State, int, int, float], State]
MOST_CORRECTIONS = 100  # of an implicit half step: each divides the change by 2/(h df/dv)


def semi_implicit_euler(
    equation: Equation, state: State, first: int, last: int, h: float
) -> State:
    """State after the steps `first` to `last` - 1 of length `h` [s]: v = v + h f(t, x, v), then
    x drifts at v."""
    f = equation.acceleration
    drifted = equation.drifted
    (x, v) = state
    for n in range(first, last):
        v = v + h * f(n * h, x, v)
        x = drifted(x, v, h)
    return x, v


def leapfrog(equation: Equation, state: State, first: int, last: int, h: float) -> State:
    """State after the steps `first` to `last` - 1 of length `h` [s]: kick half a step, drift, kick
    half a step; what depends on the rate is explicit in the first kick, implicit in the second."""
    if equation.damping_rate is None:
        return _implicit_leapfrog(equation, state, first, last, h)
    f = equation.acceleration
    (x, v) = state
    half = 0.5 * h
    damping = equation.damping_rate
    # 1 - 1/(1 + damping h/2): the factor itself has the same rounding error in each step.
    loss = half * damping / (1 + half * damping)
    still = 0.0 * v
    force = f(first * h, x, still)
    for n in range(first, last):
        v = v + half * (force - damping * v)
        x = x + h * v
        force = f((n + 1) * h, x, still)
        v = v + half * force
        v = v - loss * v
    return x, v


def _implicit_leapfrog(
    equation: Equation, state: State, first: int, last: int, h: float
) -> State:
    """The same for any dependence on the rate: the second kick by fixed-point iteration, until
    nothing changes or changes no longer shrink."""
    f = equation.acceleration
    (x, v) = state
    half = 0.5 * h
    for n in range(first, last):
        v = v + half * f(n * h, x, v)
        x = equation.drifted(x, v, h)
        kicked = v
        change = np.inf
        for _ in range(MOST_CORRECTIONS):
            corrected = kicked + half * f((n + 1) * h, x, v)
            before = change
            change = float(np.abs(corrected - v).max())
            v = corrected
            if not 0.0 < change < before:
                break
    return x, v


def rk4(equation: Equation, state: State, first: int, last: int, h: float) -> State:
    """State after the steps `first` to `last` - 1 of length `h` [s] of the classical Runge-Kutta
    method, as in the notebook Pendulo Simples. No coordinate is part of a quaternion: dx/dt = v."""
    f = equation.acceleration
    (x, v) = state
    half = 0.5 * h
    sixth = h / 6
    for n in range(first, last):
        t = n * h
        a1 = f(t, x, v)
        v2 = v + half * a1
        a2 = f(t + half, x + half * v, v2)
        v3 = v + half * a2
        a3 = f(t + half, x + half * v2, v3)
        v4 = v + h * a3
        a4 = f(t + h, x + h * v3, v4)
        x = x + sixth * (v + 2 * (v2 + v3) + v4)
        v = v + sixth * (a1 + 2 * (a2 + a3) + a4)
    return x, v


def explicit(tableau: Tableau) -> Advance:
    """The same of any explicit Runge-Kutta method."""

    def advance(equation: Equation, state: State, first: int, last: int, h: float) -> State:
        for n in range(first, last):
            slopes: list[State] = []
            for node, row in zip(tableau.nodes, tableau.matrix, strict=True):
                x, v = _moved(state, row, slopes, h)
                slopes.append(
                    (equation.slope(x, v), equation.acceleration((n + node) * h, x, v))
                )
            state = _moved(state, tableau.weights, slopes, h / tableau.divisor)
        return state

    return advance


def _moved(state: State, weights: Sequence[float], slopes: Sequence[State], h: float) -> State:
    """Both parts of a state after `h` [s] along the weighted slopes."""
    x, v = (
        start + h * sum(w * slope[part] for w, slope in zip(weights, slopes, strict=False))
        for part, start in enumerate(state)
    )
    return x, v


def advancing(equation: Equation, integrator: str) -> Advance:
    """The steps of an equation by the integrator that a `Scheme` names; raises KeyError."""
    loops = {EULER: semi_implicit_euler, LEAPFROG: leapfrog}
    if type(equation) is Equation:
        loops[RK4] = rk4
    return loops[integrator] if integrator in loops else explicit(TABLEAUX[integrator])


def fixed_steps(
    equation: Equation, integrator: str, duration: float, step: float
) -> SteppedSimulation:
    """An equation over a duration [s] in steps [s] of the integrator that a `Scheme` names: EULER,
    LEAPFROG or one of TABLEAUX, which alone take coordinates whose rate is not v; raises KeyError
    and ParameterError."""
    advance = advancing(equation, integrator)

    def build() -> Built:
        state = equation.start

        def take(first: int, last: int) -> None:
            nonlocal state
            state = advance(equation, state, first, last, step)

        return Built(
            take,
            lambda: state,
            equation.limits,
            gather=lambda states: (equation.observed(states), {}),
        )

    return SteppedSimulation(build, step_count(duration, step), step, 0.0)
