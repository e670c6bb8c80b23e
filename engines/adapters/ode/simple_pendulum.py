"""The simple pendulum as an equation of motion, exact or linear (Pendulo Simples)."""

from __future__ import annotations

import math
from typing import Any

from plumbob.engines.adapters.equation import Equation
from plumbob.engines.method import Method
from plumbob.models.largest import largest_pendulum_rates, speed_bound


def build(problem: Any, method: Method) -> Equation:
    """The equation theta'' = A sin(Omega t) - xi theta' - (g/L) sin theta. If the pendulum is
    linear, theta replaces sin theta. `problem` is a
    plumbob.analytic.systems.simple_pendulum.SimplePendulum."""
    problem = problem.started
    pull = float(problem.gravity / problem.length)
    damping = float(problem.damping_rate)
    amplitude = float(problem.forcing_amplitude)
    frequency = float(problem.forcing_frequency)
    sin = math.sin

    def free(time: float, theta: float, theta_dot: float) -> float:
        """theta'' [rad/s^2] without forcing."""
        return -damping * theta_dot - pull * sin(theta)

    def forced(time: float, theta: float, theta_dot: float) -> float:
        """theta'' [rad/s^2] with forcing."""
        return amplitude * sin(frequency * time) - damping * theta_dot - pull * sin(theta)

    def linear(time: float, theta: float, theta_dot: float) -> float:
        """theta'' [rad/s^2] of the linear pendulum."""
        return amplitude * sin(frequency * time) - damping * theta_dot - pull * theta

    exact = free if problem.rotor.autonomous else forced
    return Equation(
        linear if problem.linear else exact,
        problem.theta,
        problem.theta_dot,
        speed=speed_bound(problem, 0.0),
        damping_rate=damping,
        limits=largest_pendulum_rates(problem),
    )
