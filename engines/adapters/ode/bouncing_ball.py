"""The bouncing ball as an equation of motion. A step of the solver ends at each impact on the
floor."""

from __future__ import annotations

from typing import Any

from plumbob.engines.adapters.equation import Equation
from plumbob.engines.method import Method


def build(problem: Any, method: Method) -> Equation:
    """The equation z'' = -g above the floor, z = 0, with a coefficient of restitution; `problem` is
    a plumbob.analytic.systems.bouncing_ball.BouncingBall."""
    return Equation(
        lambda time, z, speed: -problem.gravity,
        problem.height,
        0.0,
        speed=problem.gravity * problem.fall,
        names=("z",),
        rate_names=("z_dot",),
        size=problem.height,
        restitution=problem.restitution,
    )
