"""The slider-crank in pymunk: two rods, and a slider without a turn in a groove."""

from __future__ import annotations

import math
from typing import Any

import pymunk

from plumbob.engines.adapters.pymunk.linkage import joined, linkage
from plumbob.engines.adapters.pymunk.simulation import Translation
from plumbob.engines.method import Method
from plumbob.engines.trajectory import ByName


def build(problem: Any, method: Method, step: float) -> Translation:
    """Translate a SliderCrank."""
    places = problem.opened.position
    rates = problem.opened.rate
    masses = (problem.crank_mass, problem.rod_mass)
    lengths = (problem.crank, problem.rod)
    space = linkage(
        problem.gravity, zip(masses, lengths, places[:2], rates[:2], strict=True), method
    )
    crank, rod = space.bodies
    slider = pymunk.Body(problem.slider_mass, math.inf)
    slider.position = (places[2], 0.0)
    slider.velocity = (rates[2], 0.0)
    far = 2 * sum(lengths)
    rail = pymunk.GrooveJoint(space.static_body, slider, (-far, 0.0), (far, 0.0), (0.0, 0.0))
    pin = pymunk.PivotJoint(rod, slider, (problem.rod / 2, 0.0), (0.0, 0.0))
    space.add(slider, joined(method, rail), joined(method, pin))

    def read() -> ByName:
        turning = {"angle": crank.angle, "angle_dot": crank.angular_velocity}
        return {**turning, "slider": slider.position.x}

    return Translation(space, read)
