"""A scene set up for one ODE method and its step or tolerance, and its runs."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.integrate import DOP853, LSODA, Radau
from scipy.linalg.lapack import dgetrs, zgetrs
from scipy.optimize import brentq

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array
from plumbob.engines import sampling
from plumbob.engines.adapters.equation import Equation, State
from plumbob.engines.adapters.integrators import fixed_steps
from plumbob.engines.adapters.stepping import (
    Followed,
    FollowedSimulation,
    SteppedSimulation,
    relative_tolerance,
)
from plumbob.engines.method import Method
from plumbob.engines.registry import find_builder
from plumbob.models.scene import Case

SMALLEST = 100 * ULP  # relative tolerance below which scipy refuses
SOLVERS: Mapping[str, type[Any]] = MappingProxyType(
    {"DOP853": DOP853, "Radau": Radau, "LSODA": LSODA}
)
MOST_EVALUATIONS = 1_000_000  # of a run by a solver that chooses its steps: some ten seconds
HUGE = 1e10  # a coordinate or rate (SI) beyond which a run has diverged


def prepared(case: Case, method: Method, step: float) -> SteppedSimulation | FollowedSimulation:
    """Set up `case` for `method` at `step` [s], or at the relative tolerance `step`; raises
    Unsupported and ParameterError."""
    begin = time.perf_counter()
    equation = find_builder("ode", case.system).build(case.problem, method)
    made = of_equation(equation, method, step, case.scene.duration)
    made.compile_seconds = time.perf_counter() - begin
    made.samples = case.samples
    return made


def of_equation(
    equation: Equation, method: Method, step: float, duration: float
) -> SteppedSimulation | FollowedSimulation:
    """Set up an equation for `method` at `step` [s], or at the relative tolerance `step`; raises
    ParameterError."""
    if method.control == "step":
        return fixed_steps(equation, method.scheme.integrator, duration, step)
    solver = SOLVERS[method.settings["method"]]
    return adaptive(equation, solver, relative_tolerance(step, SMALLEST), duration)


def adaptive(
    equation: Equation, solver: type[Any], rtol: float, duration: float
) -> FollowedSimulation:
    """An equation with one of scipy's solvers and a relative tolerance."""
    # absolute tolerance where a component passes zero: of the coordinates' size and the speed
    scales = [equation.size] * len(equation.names)
    scales += [equation.speed or 1.0] * len(equation.rate_names)
    tolerances = {"rtol": rtol, "atol": rtol * np.array(scales)}

    def follow(duration: float, samples: int) -> Followed:
        slope = _Slope(equation)
        times = [0.0]
        states = [np.hstack(equation.start).tolist()]

        def begin() -> Any:
            begun = solver(slope, times[-1], states[-1], duration, **tolerances)
            if samples > 1 and hasattr(begun, "solve_lu"):  # of an implicit one
                begun.solve_lu = solved
            return begun

        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            failure = _follow(begin, slope, rtol, times, states)
        # Its own steps: interpolants are less accurate.
        kept = sampling.sampled(len(times) - 1, samples)
        parts = [_parts(equation, states[k]) for k in kept]
        why = dict.fromkeys(
            filter(None, (*(str(warning.message) for warning in caught), failure))
        )
        ended = times[-1] == duration
        return Followed(np.array(times)[kept], parts, slope.evaluated, ended, tuple(why))

    limits = dict.fromkeys((*equation.names, *equation.rate_names), HUGE) | {**equation.limits}
    return FollowedSimulation(follow, equation.observed, duration, limits=limits)


def _follow(
    begin: Callable[[], Any],
    slope: _Slope,
    rtol: float,
    times: list[float],
    states: list[list[float]],
) -> str:
    """Add a solver's own steps until it ends, and return why it gave up, if so. After an impact
    another one begins, or a rest, where the next flight is lower than its tolerance."""
    equation = slope.equation
    try:
        solver = begin()
        while solver.status == "running" and sum(map(abs, states[-1])) < HUGE:
            if failure := solver.step():
                return str(failure)
            times.append(float(solver.t))
            states.append(solver.y.tolist())
            if slope.evaluated > MOST_EVALUATIONS:
                return f"given up after its budget of {MOST_EVALUATIONS} evaluations"
            if equation.restitution is not None and solver.y[0] < 0.0:
                times[-1], speed = _impact(solver, times[-2], states[-2][1])
                speed *= -equation.restitution
                states[-1] = [0.0, speed]
                pull = -equation.acceleration(times[-1], 0.0, speed)
                if speed**2 <= 2.0 * pull * rtol * equation.size:
                    times.append(float(solver.t_bound))
                    states[-1:] = [[0.0, 0.0]] * 2
                    break
                solver = begin()
    except (ValueError, OverflowError) as error:  # math and numpy, of infinity
        return " ".join(str(error).split())
    return ""


def _impact(solver: Any, begin: float, speed: float) -> tuple[float, float]:
    """When x passes 0 downward [s] in a step from `begin` [s] and this `speed` on, and x' there."""
    path = solver.dense_output()
    top = brentq(lambda t: path(t)[1], begin, solver.t) if speed > 0.0 else begin
    time = brentq(lambda t: path(t)[0], top, solver.t, xtol=ULP)
    return float(time), float(path(time)[1])


@dataclass
class _Slope:
    """An equation as scipy takes it, y' = slope(t, y) with y = (x, x'), and the number of its
    evaluations."""

    equation: Equation
    evaluated: int = 0

    def __call__(self, t: float, y: Array) -> Any:
        self.evaluated += 1
        if len(y) == 2:
            x, v = y.tolist()
            return v, self.equation.acceleration(t, x, v)
        x, v = _parts(self.equation, y)
        return np.concatenate([self.equation.slope(x, v), self.equation.acceleration(t, x, v)])


def solved(factors: tuple[Any, Any], right: Any) -> Any:
    """The result of scipy's `lu_solve`, to the bit, for one system, at a fifth of the cost of its
    checks: a run's errors need no more, while its cost is that of scipy unchanged. Raises
    ValueError where a number is not finite."""
    if not np.isfinite(right).all():
        raise ValueError("array must not contain infs or NaNs")
    solve = zgetrs if np.iscomplexobj(factors[0]) else dgetrs
    return solve(*factors, right, overwrite_b=True)[0]


def _parts(equation: Equation, y: Any) -> State:
    count = len(equation.names)
    return y[:count], y[count:]
