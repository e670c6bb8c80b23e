"""The pinched cube in pymunk, seen from the side on which it would slip: fingers in grooves."""

from __future__ import annotations

from typing import Any

import pymunk

from plumbob.engines.adapters.pymunk.rolling_ball import DEPTH
from plumbob.engines.adapters.pymunk.simulation import Translation, settle
from plumbob.engines.method import Method

ITERATIONS = 20
# iterations of the first step, for each time that cube and finger differ in mass:
SETTLING = 40.0
# one of them leaves exp(-1/that) to the next
MOST = 1_000_000


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a plumbob.analytic.systems.pinch.Pinch: x is along the load."""
    space = pymunk.Space()
    edge = problem.size
    space.collision_slop = 2.0 * DEPTH * edge
    space.iterations = ITERATIONS
    cube = pymunk.Body(problem.mass, float("inf"))
    space.add(cube, box := pymunk.Poly.create_box(cube, (edge, edge)))
    box.friction = problem.friction  # the product counts
    fingers = [
        (finger(problem, space, side), (0.0, -side * problem.normal_force))
        for side in (-1.0, 1.0)
    ]

    def press(time: float) -> None:
        cube.apply_force_at_local_point((problem.load, 0.0))
        for body, force in fingers:
            body.apply_force_at_local_point(force)

    press(0.0)
    uneven = max(problem.mass / problem.finger_mass, problem.finger_mass / problem.mass)
    settle(space, step, iterations(uneven))
    return Translation(
        space, lambda: {"slip": cube.position.x, "speed": cube.velocity.x}, act=press
    )


def iterations(uneven: float) -> int:
    """Of the first step, for masses that differ so much."""
    return min(round(SETTLING * uneven) + ITERATIONS, MOST)


def finger(problem: Any, space: pymunk.Space, side: float) -> pymunk.Body:
    """A finger on one side of the cube, in a groove across the load."""
    edge = problem.size
    body = pymunk.Body(problem.finger_mass, float("inf"))
    body.position = (0.0, side * edge * (1.0 - DEPTH))
    tip = pymunk.Poly.create_box(body, (edge / 2.0, edge))
    tip.friction = 1.0
    ends = (0.0, -4.0 * edge), (0.0, 4.0 * edge)
    groove = pymunk.GrooveJoint(space.static_body, body, *ends, (0.0, 0.0))
    groove.error_bias = 0.0
    space.add(body, tip, groove)
    return body
