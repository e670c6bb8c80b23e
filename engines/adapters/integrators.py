"""Fixed-step integrators of x'' = f(t, x, x'): semi-implicit Euler, leapfrog, RK4, tableaux.

For one coordinate the loops work on plain floats: an array of two numbers would cost more than the
arithmetic on it. For several coordinates the same code works on arrays.
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
# Largest number of iterations of an implicit half step; each divides the change by 2/(h df/dv)
MOST_CORRECTIONS = 100


def semi_implicit_euler(
    equation: Equation, state: State, first: int, last: int, h: float
) -> State:
    """The state after the steps `first` to `last` - 1 of length `h` [s]: v = v + h f(t, x, v), then
    x moves at the rate v."""
    f = equation.acceleration
    drifted = equation.drifted
    (x, v) = state
    for n in range(first, last):
        v = v + h * f(n * h, x, v)
        x = drifted(x, v, h)
    return x, v


def leapfrog(equation: Equation, state: State, first: int, last: int, h: float) -> State:
    """The state after the steps `first` to `last` - 1 of length `h` [s]: half a step of v, a step
    of x, half a step of v. Terms that depend on v are explicit in the first half step and implicit
    in the second."""
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
    """Steps as `leapfrog` for an acceleration that depends on v in any way. The second half step of
    v is found by fixed-point iteration, until the changes are zero or no longer shrink."""
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
    """The state after the steps `first` to `last` - 1 of length `h` [s] of the classical
    Runge-Kutta method, as in the notebook Pendulo Simples, for coordinates without quaternions:
    dx/dt = v."""
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
    """The function that takes steps of the explicit Runge-Kutta method of a tableau."""

    def advance(equation: Equation, state: State, first: int, last: int, h: float) -> State:
        """The state after the steps `first` to `last` - 1 of length `h` [s]."""
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
    """The state moved by `h` [s] times the weighted sum of slopes, of which there may be fewer than
    weights."""
    x, v = state
    weighted = list(zip(weights, slopes, strict=False))
    x = x + h * sum(weight * slope[0] for weight, slope in weighted)
    v = v + h * sum(weight * slope[1] for weight, slope in weighted)
    return x, v


def advancing(equation: Equation, integrator: str) -> Advance:
    """The function that takes steps of an equation by the integrator that a `Scheme` names; raises
    KeyError for an unknown one."""
    loops = {EULER: semi_implicit_euler, LEAPFROG: leapfrog}
    if type(equation) is Equation:
        loops[RK4] = rk4
    return loops[integrator] if integrator in loops else explicit(TABLEAUX[integrator])


def fixed_steps(
    equation: Equation, integrator: str, duration: float, step: float
) -> SteppedSimulation:
    """The simulation of an equation over a duration [s] in steps [s] by the integrator that a
    `Scheme` names: EULER, LEAPFROG or one of TABLEAUX. Raises KeyError and ParameterError."""
    advance = advancing(equation, integrator)

    def build() -> Built:
        """The equation at its start, with functions that advance, read and observe its state."""
        state = equation.start

        def take_steps(first: int, last: int) -> None:
            """Takes the steps `first` to `last` - 1."""
            nonlocal state
            state = advance(equation, state, first, last, step)

        return Built(
            advance=take_steps,
            read=lambda: state,
            limits=equation.limits,
            gather=lambda states: (equation.observed(states), {}),
        )

    return SteppedSimulation(build, step_count(duration, step), step, 0.0)
