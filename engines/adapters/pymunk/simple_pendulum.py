"""The simple pendulum in pymunk: a bob on a weightless rod that ends in a pivot joint, or, made
linear, a body on a rotary spring without gravity."""

from __future__ import annotations

import cmath
import math
from typing import Any

import pymunk

from plumbob.analytic.errors.contact_models.sequential_impulse import opening_error
from plumbob.engines.adapters.divergence import fastest, limits
from plumbob.engines.adapters.pymunk.methods import CLOSING_RATE, MOMENT
from plumbob.engines.adapters.pymunk.simulation import Translation
from plumbob.engines.method import Method, ModelError
from plumbob.engines.trajectory import ByName


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a plumbob.analytic.systems.simple_pendulum.SimplePendulum; raises Unsupported."""
    problem = problem.started
    return _on_a_spring(problem) if problem.linear else _on_a_rod(problem, method, step)


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


def _push(problem: Any, bob: pymunk.Body, time: float) -> pymunk.Vec2d:
    """Force of the forcing and of damping on a bob [N]."""
    forcing = problem.mass * problem.length * problem.forcing_amplitude
    damping = problem.mass * problem.length * problem.damping_rate
    push = forcing * math.sin(problem.forcing_frequency * time) - damping * bob.angular_velocity
    return pymunk.Vec2d(push * math.cos(bob.angle), push * math.sin(bob.angle))


def _on_a_rod(problem: Any, method: Method, step: float) -> Translation:
    length, gravity = problem.length, problem.gravity
    space = pymunk.Space()
    space.gravity = (0.0, -gravity)
    space.iterations = int(method.settings.get("iterations", space.iterations))
    moment = MOMENT * problem.mass * length**2
    arm = (length + math.sqrt(length**2 - 4 * moment / problem.mass)) / 2  # (I + m a^2) / (m a) = L
    bob = pymunk.Body(problem.mass, moment)
    joint = pymunk.PivotJoint(bob, space.static_body, (0.0, arm), (0.0, 0.0))
    joint.error_bias = float(method.settings.get("error_bias", joint.error_bias))
    _start(bob, joint, problem, arm, step)
    space.add(bob, joint)

    def read() -> ByName:
        theta, theta_dot = bob.angle, bob.angular_velocity
        rod = problem.mass * (length * theta_dot**2 + gravity * math.cos(theta))
        if h := space.current_time_step:  # 0 before the first step; its impulse has no sign
            outwards = bob.rotation_vector.perpendicular()
            rod = math.copysign(joint.impulse / h, (free[0] - bob.velocity).dot(-outwards))
        return {
            "theta": theta,
            "theta_dot": theta_dot,
            "tension": rod,
        }

    def before(time: float) -> None:
        free[0] = bob.velocity + step * (space.gravity + _push(problem, bob, time) / problem.mass)

    def act(time: float) -> None:
        bob.force = _push(problem, bob, time)

    free = [bob.velocity]  # what it would be after the step if there were no joint
    return Translation(
        space,
        read,
        act if problem.forcing_amplitude or problem.damping_rate else None,
        limits=limits(problem),
        before_sample=before,
    )


def _start(
    bob: pymunk.Body, joint: pymunk.PivotJoint, problem: Any, arm: float, step: float
) -> None:
    """Put the bob where it starts. A joint that closes in one step is open by what the step before
    opened: if it started closed, it would open with a jerk, which its first impulse would show."""
    theta, rate = problem.theta, problem.theta_dot
    turn = 1j * step * (rate - step * float(problem.rotor.acceleration(0.0, theta, rate)))
    opening = cmath.exp(-turn) * (1 + turn) - 1 if joint.error_bias == 0.0 else 0j
    place, speed = 1 + opening, 1j * rate - opening / step
    outwards = cmath.exp(1j * (theta - math.pi / 2))  # x + i y of the rod's direction
    bob.angle, bob.angular_velocity = theta, rate
    bob.position = (arm * outwards * place).real, (arm * outwards * place).imag
    bob.velocity = (arm * outwards * speed).real, (arm * outwards * speed).imag


def _on_a_spring(problem: Any) -> Translation:
    """No force acts on the body's centre, so that no joint is needed to keep it on the axis."""
    moment = problem.mass * problem.length**2
    space = pymunk.Space()
    wheel = pymunk.Body(problem.mass, moment)
    wheel.angle, wheel.angular_velocity = problem.theta, problem.theta_dot
    stiffness = problem.mass * problem.gravity * problem.length
    space.add(wheel, pymunk.DampedRotarySpring(wheel, space.static_body, 0.0, stiffness, 0.0))

    def read() -> ByName:
        return {"theta": wheel.angle, "theta_dot": wheel.angular_velocity}

    def act(time: float) -> None:
        push = amplitude * math.sin(frequency * time) - damping * wheel.angular_velocity
        wheel.torque = moment * push

    amplitude, frequency = problem.forcing_amplitude, problem.forcing_frequency
    damping = problem.damping_rate
    return Translation(space, read, act if amplitude or damping else None, limits=limits(problem))
