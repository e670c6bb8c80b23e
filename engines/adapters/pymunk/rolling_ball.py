"""The rolling ball in pymunk, seen from the side: a circle on a segment."""

from __future__ import annotations

from typing import Any

import pymunk

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.engines.adapters.pymunk.simulation import Translation, touching
from plumbob.engines.method import Method, ModelError, Unsupported

# of the radius: the circle's start below the line, or it touches by rounding alone
DEPTH = 1e-6
LONGEST = 60.0  # [s], of a run that ends on the segment


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The nearest point of a long segment is rounded, and tilts the normal by that over a radius,
    by which gravity acts along the line, and friction on the normal force and that on friction."""
    tilt = 4.0 * ULP * far(problem) / problem.radius * (1.0 + problem.friction) ** 2
    speed = tilt * problem.gravity * duration
    errors = {"x": speed * duration, "speed": speed, "spin": 2.5 * speed / problem.radius}
    return {name: {"a rounded normal": error} for name, error in errors.items()}


def far(problem: Any) -> float:
    """Distance to the ends of the segment [m]."""
    return float(LONGEST * problem.scale + problem.radius)


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a plumbob.analytic.systems.rolling_ball.RollingBall; raises Unsupported."""
    if problem.rolling_friction:
        raise Unsupported("pymunk has no rolling friction")
    space = pymunk.Space()
    radius = problem.radius
    space.gravity = (0.0, -problem.gravity)
    space.collision_slop = 2.0 * DEPTH * radius
    ball = pymunk.Body(problem.mass, 0.4 * problem.mass * radius**2)
    ball.position = (0.0, radius * (1.0 - DEPTH))
    ball.velocity = (problem.speed, 0.0)
    ball.angular_velocity = -problem.spin
    ends = (-far(problem), 0.0), (far(problem), 0.0)
    ground = pymunk.Segment(space.static_body, *ends, 0.0)
    touching(space, ball, (ground, pymunk.Circle(ball, radius)), friction=problem.friction)
    return Translation(
        space,
        lambda: {
            "x": ball.position.x,
            "speed": ball.velocity.x,
            "spin": -ball.angular_velocity,
        },
    )
