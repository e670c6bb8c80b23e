"""The servo in pymunk: a wheel on a spring, whose torque has the motor's limit."""

from __future__ import annotations

from typing import Any

import pymunk

from plumbob.engines.adapters.divergence import limits
from plumbob.engines.adapters.pymunk import simple_pendulum
from plumbob.engines.adapters.pymunk.simulation import Translation
from plumbob.engines.method import Method


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a plumbob.analytic.systems.servo.Servo."""
    if not problem.saturates:
        return simple_pendulum.build(problem, method, step)
    space, gear, most = pymunk.Space(), problem.gear, problem.force_limit
    wheel = pymunk.Body(1.0, problem.inertia + problem.armature)
    wheel.angle, wheel.angular_velocity = problem.theta, problem.theta_dot

    def torque(spring: pymunk.DampedRotarySpring, angle: float) -> float:
        force = -gear * (problem.kp * wheel.angle + problem.kv * wheel.angular_velocity)
        return float(-gear * min(max(force, -most), most))

    spring = pymunk.DampedRotarySpring(wheel, space.static_body, 0.0, 1.0, 0.0)
    spring.torque_func = torque
    space.add(wheel, spring)

    def act(time: float) -> None:
        wheel.torque = -problem.damping * wheel.angular_velocity

    return Translation(
        space,
        lambda: {"theta": wheel.angle, "theta_dot": wheel.angular_velocity},
        act,
        limits=limits(problem.started),
    )
