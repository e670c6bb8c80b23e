"""The linear pendulum in pymunk's terms: a body on a rotary spring, without gravity."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import pymunk

from plumbob.analytic.systems.pendulums.rod_tension import MASS
from plumbob.engines.adapters.pymunk.translation import Translation
from plumbob.engines.adapters.swing_limit import limits
from plumbob.engines.method import Method


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a linear simple_pendulum.SimplePendulum: nothing pulls on the body's
    centre, which so needs no joint to stay where the axis is."""
    moment = MASS * problem.length**2
    space = pymunk.Space()
    wheel = pymunk.Body(MASS, moment)
    wheel.angle, wheel.angular_velocity = problem.theta, problem.theta_dot
    stiffness = MASS * problem.gravity * problem.length
    space.add(wheel, pymunk.DampedRotarySpring(wheel, space.static_body, 0.0, stiffness, 0.0))

    def read() -> Mapping[str, float]:
        return {"theta": wheel.angle, "theta_dot": wheel.angular_velocity}

    def act(time: float) -> None:
        push = amplitude * math.sin(frequency * time) - damping * wheel.angular_velocity
        wheel.torque = moment * push

    amplitude, frequency = problem.forcing_amplitude, problem.forcing_frequency
    damping = problem.damping_rate
    return Translation(space, read, act if amplitude or damping else None, limits=limits(problem))


def model_error(
    problem: Any, duration: float, method: Method, step: float
) -> Mapping[str, Mapping[str, float]]:
    """Nothing: the body's moment of inertia is that of the bob about the axis."""
    return {}
