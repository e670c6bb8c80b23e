"""Simulations of scenes by ODE methods, at a step or at a tolerance."""

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

SMALLEST = 100 * ULP  # smallest relative tolerance that scipy accepts
SOLVERS: Mapping[str, type[Any]] = MappingProxyType(
    {"DOP853": DOP853, "Radau": Radau, "LSODA": LSODA}
)
# largest number of evaluations in a run by a solver that chooses its steps: about ten seconds
MOST_EVALUATIONS = 1_000_000
HUGE = 1e10  # coordinate or rate (SI) beyond which a run has diverged


def prepared(case: Case, method: Method, step: float) -> SteppedSimulation | FollowedSimulation:
    """The simulation of a case by a method at `step` [s], or at the relative tolerance `step`;
    raises Unsupported and ParameterError."""
    begin = time.perf_counter()
    equation = find_builder("ode", case.system).build(case.problem, method)
    simulation = simulation_of(equation, method, step, case.scene.duration)
    simulation.compile_seconds = time.perf_counter() - begin
    simulation.samples = case.samples
    return simulation


def simulation_of(
    equation: Equation, method: Method, step: float, duration: float
) -> SteppedSimulation | FollowedSimulation:
    """The simulation of an equation over a duration [s] by a method at `step` [s], or at the
    relative tolerance `step`; raises ParameterError."""
    if method.control == "step":
        return fixed_steps(equation, method.scheme.integrator, duration, step)
    solver = SOLVERS[method.settings["method"]]
    return adaptive(equation, solver, relative_tolerance(step, SMALLEST), duration)


def adaptive(
    equation: Equation, solver: type[Any], rtol: float, duration: float
) -> FollowedSimulation:
    """The simulation of an equation over a duration [s] by a solver of scipy at a relative
    tolerance."""
    # A component that passes zero needs an absolute tolerance: it is the relative tolerance times
    # the size of the coordinates, or times the speed.
    scales = [equation.size] * len(equation.names)
    scales += [equation.speed or 1.0] * len(equation.rate_names)
    tolerances = {"rtol": rtol, "atol": rtol * np.array(scales)}

    def follow(duration: float, samples: int) -> Followed:
        """Integrates from the start over a duration [s], by the solver's own steps."""
        slope = _Slope(equation)
        times = [0.0]
        states = [np.hstack(equation.start).tolist()]

        def new_solver() -> Any:
            """A solver that begins at the last state."""
            started = solver(slope, times[-1], states[-1], duration, **tolerances)
            if samples > 1 and hasattr(started, "solve_lu"):  # the solver is implicit
                started.solve_lu = unchecked_lu_solve
            return started

        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            failure = _follow(new_solver, slope, rtol, times, states)
        # Samples are taken at ends of the solver's steps: its interpolants are less accurate.
        sampled_steps = sampling.sampled(len(times) - 1, samples)
        messages = [str(warning.message) for warning in caught]
        messages.append(failure)
        return Followed(
            times=np.array(times)[sampled_steps],
            states=[_split(equation, states[number]) for number in sampled_steps],
            evaluations=slope.evaluations,
            ended=times[-1] == duration,
            why=tuple(dict.fromkeys(filter(None, messages))),
        )

    limits = dict.fromkeys((*equation.names, *equation.rate_names), HUGE) | {**equation.limits}
    return FollowedSimulation(follow, equation.observed, duration, limits=limits)


def _follow(
    new_solver: Callable[[], Any],
    slope: _Slope,
    rtol: float,
    times: list[float],
    states: list[list[float]],
) -> str:
    """Appends the steps of a solver to `times` [s] and `states` until the solver ends; returns why
    the solver gave up, or an empty string. At an impact the step is cut, and a new solver begins.
    If the next flight would be lower than the tolerance, the body rests instead."""
    equation = slope.equation
    try:
        solver = new_solver()
        while solver.status == "running" and sum(map(abs, states[-1])) < HUGE:
            failure = solver.step()
            if failure:
                return str(failure)
            times.append(float(solver.t))
            states.append(solver.y.tolist())
            if slope.evaluations > MOST_EVALUATIONS:
                return f"given up after its budget of {MOST_EVALUATIONS} evaluations"
            if equation.restitution is not None and solver.y[0] < 0.0:
                _, speed_before = states[-2]
                times[-1], impact_speed = _impact(solver, times[-2], speed_before)
                speed = -equation.restitution * impact_speed
                states[-1] = [0.0, speed]
                gravity = -equation.acceleration(times[-1], 0.0, speed)
                if speed**2 <= 2.0 * gravity * rtol * equation.size:
                    times.append(float(solver.t_bound))
                    states[-1:] = [[0.0, 0.0]] * 2
                    break
                solver = new_solver()
    except (ValueError, OverflowError) as error:  # math and numpy refuse infinite numbers
        return " ".join(str(error).split())
    return ""


def _impact(solver: Any, begin: float, speed: float) -> tuple[float, float]:
    """The time [s] at which x passes 0 downward in the last step of a solver, and x' at that time.
    The step begins at the time `begin` [s] with x' = `speed`."""
    path = solver.dense_output()
    top = brentq(lambda t: path(t)[1], begin, solver.t) if speed > 0.0 else begin
    time = brentq(lambda t: path(t)[0], top, solver.t, xtol=ULP)
    return float(time), float(path(time)[1])


@dataclass
class _Slope:
    """An equation in scipy's form, y' = slope(t, y) with y = (x, x'), and the number of evaluations
    of the slope."""

    equation: Equation
    evaluations: int = 0

    def __call__(self, t: float, y: Array) -> Any:
        """The slope y' at a time [s]."""
        self.evaluations += 1
        if len(y) == 2:
            x, v = y.tolist()
            return v, self.equation.acceleration(t, x, v)
        x, v = _split(self.equation, y)
        return np.concatenate([self.equation.slope(x, v), self.equation.acceleration(t, x, v)])


def unchecked_lu_solve(factors: tuple[Any, Any], right: Any) -> Any:
    """The result of scipy's `lu_solve` for one system of equations, to the bit, without the checks
    that take four fifths of the time. It is used where only the errors of a run count; the cost of
    a step is timed with scipy's function. Raises ValueError if a number is not finite."""
    if not np.isfinite(right).all():
        raise ValueError("array must not contain infs or NaNs")
    solve = zgetrs if np.iscomplexobj(factors[0]) else dgetrs
    return solve(*factors, right, overwrite_b=True)[0]


def _split(equation: Equation, y: Any) -> State:
    """The coordinates and the rates in y = (x, x')."""
    count = len(equation.names)
    return y[:count], y[count:]
