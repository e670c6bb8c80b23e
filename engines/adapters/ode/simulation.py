"""A scene set up for one ODE method and its step or tolerance, and its runs."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.integrate import DOP853, LSODA, Radau
from scipy.linalg.lapack import dgetrs, zgetrs
from scipy.optimize import brentq

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array
from plumbob.engines import sampling
from plumbob.engines.adapters.divergence import within
from plumbob.engines.adapters.equation import Equation, State
from plumbob.engines.adapters.integrators import fixed_steps, integrator
from plumbob.engines.adapters.ode.turning import TurningEquation
from plumbob.engines.adapters.stepping import SteppedSimulation, relative_tolerance
from plumbob.engines.method import Method, Stepping
from plumbob.engines.registry import find_builder
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case

SMALLEST = 100 * ULP  # relative tolerance below which scipy refuses
SOLVERS: Mapping[str, type[Any]] = MappingProxyType(
    {"DOP853": DOP853, "Radau": Radau, "LSODA": LSODA}
)
HUGE = 1e10  # a coordinate or rate (SI) beyond which a run has diverged


def prepared(case: Case, method: Method, step: float) -> SteppedSimulation | AdaptiveSimulation:
    """Set up `case` for `method` at `step` [s], or at the relative tolerance `step`; raises
    Unsupported and ParameterError."""
    begin = time.perf_counter()
    equation = find_builder("ode", case.system).build(case.problem, method)
    made = of_equation(equation, method, step, case.scene.duration)
    made.compile_seconds, made.samples = time.perf_counter() - begin, case.samples
    return made


def of_equation(
    equation: Equation, method: Method, step: float, duration: float
) -> SteppedSimulation | AdaptiveSimulation:
    """Set up an equation for `method` at `step` [s], or at the relative tolerance `step`; raises
    ParameterError."""
    if method.control == "step":
        steps = sampling.step_count(duration, step)
        turning = isinstance(equation, TurningEquation)
        advance = integrator(method.scheme.integrator, turning)
        return fixed_steps(equation, advance, steps, step)
    solver = SOLVERS[method.settings["method"]]
    return AdaptiveSimulation(equation, solver, relative_tolerance(step, SMALLEST), duration, 0.0)


@dataclass
class AdaptiveSimulation:
    """An equation with one of scipy's solvers and a relative tolerance; `run` starts afresh."""

    equation: Equation
    solver: type[Any]
    rtol: float
    duration: float  # [s]
    compile_seconds: float
    samples: int = sampling.SAMPLES

    def run(self) -> Trajectory:
        """Run from the start to the end, or until the run diverges or the solver gives up."""
        equation, slope = self.equation, _Slope(self.equation)
        times, states = [0.0], [np.hstack(equation.start).tolist()]
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            begin = time.perf_counter()
            failure = self._follow(slope, times, states, solved)
            seconds = time.perf_counter() - begin
        reached = times[-1]
        kept = sampling.sampled(
            len(times) - 1, self.samples
        )  # its own steps: interpolants are less accurate
        messages = [*(str(warning.message) for warning in caught), *([failure] if failure else [])]
        trajectory = Trajectory(
            times=np.array(times)[kept],
            observables=equation.observed([_parts(equation, states[k]) for k in kept]),
            steps=slope.evaluated,
            seconds=seconds,
            diverged_at=None if reached == self.duration else reached,
            warnings=tuple(dict.fromkeys(messages)),
        )
        far = dict.fromkeys((*equation.names, *equation.rate_names), HUGE)
        return within(trajectory, {**far, **equation.limits})

    def stepped(self, fraction: float) -> Stepping:
        """The evaluations of the first `fraction` of the duration alone."""
        piece, slope = replace(self, duration=fraction * self.duration), _Slope(self.equation)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            begin = time.thread_time()
            piece._follow(slope, [0.0], [np.hstack(self.equation.start).tolist()])
            return Stepping(slope.evaluated, time.thread_time() - begin)

    def _follow(
        self,
        slope: _Slope,
        times: list[float],
        states: list[Any],
        linear: Callable[[tuple[Any, Any], Any], Any] | None = None,
    ) -> str | None:
        """Add the solver's own steps to `times` and `states`, and return why it gave up, if so;
        `linear`, where given, solves an implicit solver's linear systems in scipy's place."""
        equation = self.equation
        # absolute tolerance where a component passes zero: of the coordinates' size and the speed
        scales = [equation.size] * len(equation.names)
        scales += [equation.speed or 1.0] * len(equation.rate_names)
        atol, failure = self.rtol * np.array(scales), None
        try:
            while times[-1] < self.duration and sum(map(abs, states[-1])) < HUGE and not failure:
                solver = self.solver(
                    slope, times[-1], states[-1], self.duration, rtol=self.rtol, atol=atol
                )
                if linear is not None and hasattr(solver, "solve_lu"):
                    solver.solve_lu = linear
                failure = self._stepped(solver, times, states)
        except (ValueError, OverflowError) as error:  # math and numpy, of infinity
            return " ".join(str(error).split())
        return failure

    def _stepped(self, solver: Any, times: list[float], states: list[Any]) -> str | None:
        """Add a solver's steps until it ends, and return why it failed, if so, or until an impact,
        after which another begins: a rest where the next flight is lower than its tolerance."""
        equation = self.equation
        while solver.status == "running" and sum(map(abs, states[-1])) < HUGE:
            failure = solver.step()
            if solver.status == "failed":
                return str(failure)
            times.append(float(solver.t))
            states.append(solver.y.tolist())
            if equation.restitution is not None and solver.y[0] < 0.0:
                times[-1], speed = _impact(solver, times[-2], states[-2][1])
                speed *= -equation.restitution
                states[-1] = [0.0, speed]
                pull = -equation.acceleration(times[-1], 0.0, speed)
                if speed**2 <= 2.0 * pull * self.rtol * equation.size:
                    times.append(self.duration)
                    states[-1:] = [[0.0, 0.0]] * 2
                break
        return None


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
