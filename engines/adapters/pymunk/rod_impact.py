"""The falling rod in pymunk, seen from the side: a body with a small circle at each end, above a
thick segment."""

from __future__ import annotations

from typing import Any

import numpy as np
import pymunk

from plumbob.analytic.errors.contact_models.impacts import ITERATIONS
from plumbob.analytic.errors.contact_models.rod_steps import TIP
from plumbob.engines.adapters.pymunk.simulation import Translation, touching
from plumbob.engines.method import Method

LONGEST = 1e2  # lengths to either end of the floor, and half of its thickness


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a plumbob.analytic.systems.rod_impact.RodImpact."""
    space = pymunk.Space()
    size = problem.length
    space.gravity = (0.0, -problem.gravity)
    space.iterations = ITERATIONS
    space.collision_slop = LONGEST * size  # no depth is closed beside the steps
    rod = pymunk.Body(problem.mass, problem.mass * size**2 / 12.0)
    begun = {name: float(value[0]) for name, value in problem.observe(np.zeros(1)).items()}
    rod.position = (0.0, begun["z"])
    rod.angle = begun["angle"]
    rod.velocity = (problem.speed, 0.0)
    deep = -LONGEST * size
    ground = pymunk.Segment(space.static_body, (deep, deep), (-deep, deep), -deep)
    tips = [pymunk.Circle(rod, TIP * size, (side, 0.0)) for side in (-size / 2.0, size / 2.0)]
    surface = {"friction": problem.friction, "elasticity": problem.restitution}
    touching(space, rod, (ground, *tips), **surface)
    return Translation(
        space, lambda: {"x": rod.position.x, "z": rod.position.y, "angle": rod.angle}
    )
