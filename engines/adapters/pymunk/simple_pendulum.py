"""The simple pendulum in pymunk: a bob on a weightless rod that ends in a pivot joint, or, made
linear, a body on a rotary spring without gravity."""

from __future__ import annotations

import cmath
import math
from typing import Any

import pymunk

from plumbob.analytic.errors.contact_models.sequential_impulse import opening_error
from plumbob.engines.adapters.pymunk.linkage import joined
from plumbob.engines.adapters.pymunk.methods import CLOSING_RATE, MOMENT
from plumbob.engines.adapters.pymunk.simulation import Translation, vector
from plumbob.engines.adapters.pymunk.wheel import Torque, wheel
from plumbob.engines.method import Method, ModelError
from plumbob.engines.trajectory import ByName
from plumbob.models.largest import fastest, rates_of_a_pendulum


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a plumbob.analytic.systems.simple_pendulum.SimplePendulum; raises Unsupported."""
    problem = problem.started
    amplitude = problem.forcing_amplitude
    frequency = problem.forcing_frequency
    moment = problem.mass * problem.length**2
    damping = problem.damping_rate

    def push(time: float, rate: float) -> float:
        """Torque of the forcing and of damping [N m]."""
        return float(moment * (amplitude * math.sin(frequency * time) - damping * rate))

    drive = push if amplitude or damping else None
    if not problem.linear:
        return _on_a_rod(problem, method, step, drive)
    stiffness = problem.mass * problem.gravity * problem.length
    return wheel(problem, moment, rates_of_a_pendulum(problem), stiffness=stiffness, push=drive)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Tension: what the bob's moment of inertia adds, whose centre is nearer to the pivot and pulls
    less, and what the rounding of the joint's opening makes, across the rod that of the rate. On
    the spring nothing: the body's moment of inertia is that of the bob about the axis."""
    if problem.started.linear:
        return {}
    moment = MOMENT * problem.mass * problem.length * fastest(problem, duration) ** 2
    closing = 1 / step if method.settings.get("error_bias") == 0.0 else CLOSING_RATE
    rounding = opening_error(problem.mass, problem.length, closing, step)
    return {
        "theta_dot": {"rounded opening": rounding * step / (problem.mass * problem.length)},
        "tension": {"moment of the bob": moment, "rounded opening": rounding},
    }


def _on_a_rod(problem: Any, method: Method, step: float, push: Torque | None) -> Translation:
    length = problem.length
    gravity = problem.gravity
    space = pymunk.Space()
    space.gravity = (0.0, -gravity)
    space.iterations = int(method.settings.get("iterations", space.iterations))
    moment = MOMENT * problem.mass * length**2
    # (I + m a^2) / (m a) = L
    arm = (length + math.sqrt(length**2 - 4 * moment / problem.mass)) / 2
    bob = pymunk.Body(problem.mass, moment)
    joint = joined(method, pymunk.PivotJoint(bob, space.static_body, (0.0, arm), (0.0, 0.0)))
    _start(bob, problem, arm, step if joint.error_bias == 0.0 else None)
    space.add(bob, joint)
    free = bob.velocity  # what it would be after the step if there were no joint

    def act(time: float) -> None:
        if push is not None:
            bob.force = bob.rotation_vector * (push(time, bob.angular_velocity) / length)

    def before(time: float) -> None:
        nonlocal free
        act(time)
        free = bob.velocity + step * (space.gravity + bob.force / problem.mass)

    def read() -> ByName:
        theta = bob.angle
        theta_dot = bob.angular_velocity
        rod = problem.mass * (length * theta_dot**2 + gravity * math.cos(theta))
        if h := space.current_time_step:  # 0 before the first step; its impulse has no sign
            outwards = bob.rotation_vector.perpendicular()
            rod = math.copysign(joint.impulse / h, (free - bob.velocity).dot(-outwards))
        return {"theta": theta, "theta_dot": theta_dot, "tension": rod}

    return Translation(
        space,
        read,
        act if push else None,
        limits=rates_of_a_pendulum(problem),
        before_sample=before,
    )


def _start(bob: pymunk.Body, problem: Any, arm: float, step: float | None) -> None:
    """Put the bob where it starts. A joint that closes in one step is open by what the `step`
    before opened: if it started closed, it would open with a jerk, which its first impulse would
    show."""
    theta = problem.theta
    rate = problem.theta_dot
    place = 1 + 0j
    speed = 1j * problem.theta_dot
    if step is not None:
        turn = 1j * step * (rate - step * float(problem.rotor.acceleration(0.0, theta, rate)))
        opening = cmath.exp(-turn) * (1 + turn) - 1
        place = place + opening
        speed = speed - opening / step
    outwards = arm * cmath.exp(1j * (theta - math.pi / 2))  # x + i y of the rod
    bob.angle, bob.angular_velocity = theta, rate
    bob.position, bob.velocity = vector(outwards * place), vector(outwards * speed)
