"""The cube on an incline in pymunk, seen from the side: a box on a segment that does not turn."""

from __future__ import annotations

from typing import Any

import pymunk

from plumbob.engines.adapters.pymunk.rolling_ball import DEPTH
from plumbob.engines.adapters.pymunk.simulation import Translation, touching
from plumbob.engines.method import Method

LONGEST = 1e4  # [m], of a way on the segment


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a plumbob.analytic.systems.incline.Incline; the heading has no effect."""
    space = pymunk.Space()
    edge = problem.size
    space.gravity = (problem.pull, -problem.press)
    space.collision_slop = 2.0 * DEPTH * edge
    cube = pymunk.Body(problem.mass, float("inf"))
    cube.position = (0.0, edge * (0.5 - DEPTH))
    cube.velocity = (problem.speed, 0.0)
    ground = pymunk.Segment(space.static_body, (-LONGEST, 0.0), (LONGEST, 0.0), 0.0)
    box = pymunk.Poly.create_box(cube, (edge, edge))
    touching(space, cube, (ground, box), friction=problem.friction)
    return Translation(space, lambda: {"x": cube.position.x, "speed": cube.velocity.x})
