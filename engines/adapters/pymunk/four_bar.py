"""The four-bar linkage in pymunk: a chain of rods, pinned at both ends."""

from __future__ import annotations

from typing import Any

import pymunk

from plumbob.engines.adapters.pymunk import n_pendulum
from plumbob.engines.adapters.pymunk.linkage import joined
from plumbob.engines.adapters.pymunk.simulation import Translation
from plumbob.engines.method import Method
from plumbob.engines.trajectory import ByName


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a FourBar."""
    space = n_pendulum.build(problem.chain, method, step).space
    (crank, coupler, rocker) = space.bodies
    end = (problem.rocker / 2, 0.0)
    axis = (problem.ground, 0.0)
    space.add(joined(method, pymunk.PivotJoint(rocker, space.static_body, end, axis)))

    def read() -> ByName:
        place = coupler.position
        return {
            "angle": crank.angle,
            "angle_dot": crank.angular_velocity,
            "coupler_x": place.x,
            "coupler_y": place.y,
        }

    return Translation(space, read)
