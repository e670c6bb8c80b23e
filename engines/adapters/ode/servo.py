"""The servo as an equation of motion: a linear oscillator, whose motor may have a limited force."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from plumbob.engines.adapters.equation import Equation
from plumbob.engines.adapters.ode import simple_pendulum
from plumbob.engines.method import Method, Unsupported


def build(problem: Any, method: Method) -> Equation:
    """Returns the equation J x'' = n F - c x' of the angle x, which is theta in the code. n is the
    gear ratio, c the damping, and F = -n (kp x + kv x') the force, clamped to its limit. `problem`
    is a plumbob.analytic.systems.servo.Servo. Raises Unsupported for a digital controller."""
    if problem.loop is not None:
        raise Unsupported("its controls are fed back, and the equation has none")
    linear = simple_pendulum.build(problem, method)
    if not problem.saturates:
        return linear
    inertia = problem.inertia + problem.armature
    force_limit = problem.force_limit
    gear = problem.gear
    kp = gear * problem.kp
    kv = gear * problem.kv
    damping = problem.damping

    def limited(time: float, theta: float, theta_dot: float) -> float:
        """x'' [rad/s^2] with the clamped force."""
        force = min(max(-kp * theta - kv * theta_dot, -force_limit), force_limit)
        return float((gear * force - damping * theta_dot) / inertia)

    return replace(linear, acceleration=limited, damping_rate=None)
