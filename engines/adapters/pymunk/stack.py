"""The stack in pymunk: boxes on a segment, which do not turn."""

from __future__ import annotations

from typing import Any

import pymunk

from plumbob.engines.adapters.pymunk.pinch import ITERATIONS, MOST, SETTLING
from plumbob.engines.adapters.pymunk.rolling_ball import DEPTH
from plumbob.engines.adapters.pymunk.simulation import Translation
from plumbob.engines.adapters.stepping import no_error
from plumbob.engines.method import Method

model_error = no_error


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a plumbob.analytic.systems.stack.Stack."""
    space, edge = pymunk.Space(), problem.size
    space.gravity, space.collision_slop = (0.0, -problem.gravity), 2.0 * DEPTH * edge
    space.add(pymunk.Segment(space.static_body, (-edge, 0.0), (edge, 0.0), 0.0))
    cubes, places = [], []
    for i, mass in enumerate(problem.masses):
        cube = pymunk.Body(mass, float("inf"))
        places.append((0.0, edge * (i + 0.5 - DEPTH * (i + 1))))
        cube.position = places[-1]
        space.add(cube, pymunk.Poly.create_box(cube, (edge, edge)))
        cubes.append(cube)
    uneven = max(problem.mass_ratio, 1.0 / problem.mass_ratio) * problem.count**2
    space.iterations = min(round(SETTLING * uneven) + ITERATIONS, MOST)
    space.step(step)  # and undone: the solver begins with the impulses of a step before
    space.iterations = ITERATIONS
    for cube, place in zip(cubes, places, strict=True):
        cube.position, cube.velocity = place, (0.0, 0.0)
    return Translation(space, lambda: {"top": cubes[-1].position.y - places[-1][1]})
