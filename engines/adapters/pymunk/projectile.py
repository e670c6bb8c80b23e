"""A projectile in pymunk: a free body."""

from __future__ import annotations

from typing import Any

import pymunk

from plumbob.engines.adapters.pymunk.simulation import Translation
from plumbob.engines.method import Method


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a Projectile."""
    space = pymunk.Space()
    body = pymunk.Body(1.0, 1.0)
    system = problem.motion.system
    space.gravity = (0.0, -problem.gravity)
    *velocity, body.angular_velocity = system.rate
    body.velocity = velocity[0], velocity[1]
    space.add(body)

    def read() -> dict[str, float]:
        state = *body.position, body.angle, *body.velocity, body.angular_velocity
        return dict(zip((*system.coordinates, *system.rates), state, strict=True))

    return Translation(space, read)
