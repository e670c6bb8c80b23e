"""A run of one of scipy's adaptive solvers, of an equation of motion."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import DOP853, LSODA, Radau

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.adapters import sampling
from plumbob.engines.adapters.divergence import within
from plumbob.engines.adapters.ode.equation import Equation
from plumbob.engines.trajectory import Trajectory

SOLVERS: tuple[type[Any], ...] = (DOP853, Radau, LSODA)
HUGE = 1e10  # an angle [rad] or rate [rad/s] beyond which nothing is worth following


def solver_called(name: str) -> type[Any]:
    """The solver of SOLVERS called `name`; raises ParameterError."""
    for solver in SOLVERS:
        if solver.__name__ == name:
            return solver
    names = ", ".join(solver.__name__ for solver in SOLVERS)
    raise ParameterError("method", name, f"one of {names}")


@dataclass
class AdaptiveSimulation:
    """An equation with one of scipy's solvers and a relative tolerance; every `run` begins anew."""

    equation: Equation
    solver: type[Any]
    rtol: float
    duration: float  # [s]
    compile_seconds: float

    def run(self) -> Trajectory:
        """Run from the start to the end, or until the run diverges or the solver gives up."""
        equation = self.equation
        evaluated = 0

        def slope(t: float, y: Array) -> tuple[float, float]:
            nonlocal evaluated
            evaluated += 1
            theta, theta_dot = y.tolist()
            return theta_dot, equation.acceleration(t, theta, theta_dot)

        times, states = [0.0], [(equation.theta, equation.theta_dot)]
        # absolute where a component passes zero: of a radian, and of the motion's speed
        atol = self.rtol * np.array([1.0, equation.speed or 1.0])
        failure: str | None = None
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            begin = time.perf_counter()
            try:
                solver = self.solver(
                    slope, 0.0, states[0], self.duration, rtol=self.rtol, atol=atol
                )
                while solver.status == "running" and abs(states[-1][0]) + abs(states[-1][1]) < HUGE:
                    failure = solver.step()
                    if solver.status != "failed":
                        times.append(float(solver.t))
                        states.append(tuple(solver.y.tolist()))
            except (ValueError, OverflowError) as error:  # what math and numpy say to infinity
                failure = " ".join(str(error).split())
            seconds = time.perf_counter() - begin
        reached = times[-1]
        kept = sampling.sampled(len(times) - 1)  # its own steps: interpolants err by more
        theta, theta_dot = np.array(states)[kept].T
        told = [*(str(warning.message) for warning in caught), *([failure] if failure else [])]
        trajectory = Trajectory(
            times=np.array(times)[kept],
            observables={"theta": theta, "theta_dot": theta_dot},
            steps=evaluated,
            seconds=seconds,
            diverged_at=None if reached == self.duration else reached,
            warnings=tuple(dict.fromkeys(told)),
        )
        return within(trajectory, {"theta": HUGE, "theta_dot": HUGE, **equation.limits})
