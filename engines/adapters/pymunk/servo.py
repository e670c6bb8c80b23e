"""The servo in pymunk: a wheel on a spring, whose torque has the motor's limit."""

from __future__ import annotations

from typing import Any

from plumbob.engines.adapters.pymunk import simple_pendulum
from plumbob.engines.adapters.pymunk.simulation import Translation
from plumbob.engines.adapters.pymunk.wheel import wheel
from plumbob.engines.method import Method
from plumbob.models.largest import rates_of_a_pendulum


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a plumbob.analytic.systems.servo.Servo."""
    if not problem.saturates:
        return simple_pendulum.build(problem, method, step)
    gear = problem.gear
    most = problem.force_limit

    def torque(angle: float, rate: float) -> float:
        force = -gear * (problem.kp * angle + problem.kv * rate)
        return float(gear * min(max(force, -most), most))

    return wheel(
        problem,
        problem.inertia + problem.armature,
        rates_of_a_pendulum(problem.started),
        torque=torque,
        push=lambda time, rate: -problem.damping * rate,
    )
