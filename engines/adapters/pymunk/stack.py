"""The stack in pymunk: boxes on a segment, which do not turn."""

from __future__ import annotations

from typing import Any

import pymunk

from plumbob.engines.adapters.pymunk.pinch import ITERATIONS, iterations
from plumbob.engines.adapters.pymunk.rolling_ball import DEPTH
from plumbob.engines.adapters.pymunk.simulation import Translation, settle
from plumbob.engines.method import Method


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a plumbob.analytic.systems.stack.Stack."""
    space = pymunk.Space()
    edge = problem.size
    space.iterations = ITERATIONS
    space.gravity = (0.0, -problem.gravity)
    space.collision_slop = 2.0 * DEPTH * edge
    space.add(pymunk.Segment(space.static_body, (-edge, 0.0), (edge, 0.0), 0.0))
    for i, mass in enumerate(problem.masses):
        cube = pymunk.Body(mass, float("inf"))
        cube.position = (0.0, edge * (i + 0.5 - DEPTH * (i + 1)))
        space.add(cube, pymunk.Poly.create_box(cube, (edge, edge)))
    begun = cube.position.y
    uneven = max(problem.mass_ratio, 1.0 / problem.mass_ratio)
    settle(space, step, iterations(uneven * problem.count**2))
    return Translation(space, lambda: {"top": cube.position.y - begun})
