"""A run with a fixed step, of an equation of motion."""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plumbob.engines.adapters import sampling
from plumbob.engines.adapters.divergence import within
from plumbob.engines.adapters.ode.equation import Equation
from plumbob.engines.adapters.ode.fixed_step import Advance
from plumbob.engines.trajectory import Trajectory


@dataclass
class FixedStepSimulation:
    """An equation with an integrator and a step [s]; every `run` begins anew."""

    equation: Equation
    advance: Advance
    steps: int
    step: float
    compile_seconds: float

    def run(self) -> Trajectory:
        """Run from the start to the end, or until the run diverges."""
        marks = [int(mark) for mark in sampling.sampled(self.steps)]
        states = [(self.equation.theta, self.equation.theta_dot)]
        diverged, begin = None, time.perf_counter()
        try:
            for first, last in pairwise(marks):
                states.append(self.advance(self.equation, states[-1], first, last, self.step))
        except (ValueError, OverflowError):  # what math.sin says to infinity
            diverged = marks[len(states)] * self.step
        seconds = time.perf_counter() - begin
        theta, theta_dot = np.array(states).T
        trajectory = Trajectory(
            times=np.array(marks[: len(states)]) * self.step,
            observables={"theta": theta, "theta_dot": theta_dot},
            steps=marks[len(states) - 1],
            seconds=seconds,
            diverged_at=diverged,
        )
        return within(trajectory, self.equation.limits)
