"""The bouncing ball in pymunk: a circle above a segment, with elasticity."""

from __future__ import annotations

from typing import Any

import pymunk

from plumbob.analytic.errors.contact_models.impacts import KEPT, SLOP
from plumbob.engines.adapters.pymunk.simulation import Translation, touching
from plumbob.engines.method import Method

RADIUS = 0.1  # [m]


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a plumbob.analytic.systems.bouncing_ball.BouncingBall."""
    space = pymunk.Space()
    space.gravity = (0.0, -problem.gravity)
    space.collision_slop = SLOP * problem.height
    space.collision_bias = KEPT
    ball = pymunk.Body(1.0, float("inf"))
    ball.position = (0.0, problem.height + RADIUS)
    ground = pymunk.Segment(space.static_body, (-1.0, 0.0), (1.0, 0.0), 0.0)
    shapes = ground, pymunk.Circle(ball, RADIUS)
    touching(space, ball, shapes, elasticity=problem.restitution)
    return Translation(space, lambda: {"z": ball.position.y - RADIUS})
