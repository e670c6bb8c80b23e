"""A chain of rods in pymunk: a pin at each end but the last."""

from __future__ import annotations

import math
from typing import Any

from plumbob.engines.adapters.pymunk.linkage import linkage
from plumbob.engines.adapters.pymunk.simulation import Translation
from plumbob.engines.method import Method
from plumbob.engines.trajectory import ByName


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate an NPendulum."""
    masses, lengths, rates = map(problem.each, ("masses", "lengths", "angular_velocities"))
    angles = [angle - math.pi / 2 for angle in problem.each("angles")]
    space = linkage(problem.gravity, zip(masses, lengths, angles, rates, strict=True), method)
    system = problem.motion.system
    rods = list(space.bodies)
    end = (lengths[-1] / 2, 0.0)

    def read() -> ByName:
        tip = rods[-1].local_to_world(end)
        state = [
            *(rod.angle + math.pi / 2 for rod in rods),
            *(rod.angular_velocity for rod in rods),
        ]
        named = dict(zip((*system.coordinates, *system.rates), state, strict=True))
        return {"tip_x": tip.x, "tip_z": tip.y, **named}

    return Translation(space, read)
