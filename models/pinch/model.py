"""The numbers of a cube between two fingers in pinch.xml."""

from __future__ import annotations

from typing import Any

from plumbob.analytic.systems.pinch import Pinch

TIPS = ("left", "right")


def fill(spec: Any, problem: Pinch) -> None:
    """Write the numbers of a pinched cube into an MjSpec of pinch.xml. The frame is the hand's: the
    hand's acceleration is part of gravity."""
    from plumbob.analytic.errors.contact_models.held_bodies import TIP

    half = problem.size / 2.0
    radius = TIP * problem.size
    down, across = problem.pull / problem.mass
    cube = spec.body("cube")
    spec.option.gravity = [across, 0.0, -down]
    cube.mass = problem.mass
    cube.inertia = [problem.mass * problem.size**2 / 6.0] * 3
    spec.geom("cube").size = [half] * 3
    for tip, side in zip(TIPS, (-1.0, 1.0), strict=True):
        spec.geom(tip).size[0] = radius
        spec.body(tip).mass = problem.finger_mass
        spec.body(tip).pos = [0.0, side * (half + radius), 0.0]
        spec.pair(tip).friction[:2] = [problem.friction] * 2
    spec.key("start").ctrl = [problem.normal_force] * 2
