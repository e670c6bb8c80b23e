"""The relation of a cube between two fingers to pinch.xml."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.pinch import Pinch
from plumbob.models.model_file import Controls, ModelFile

TIPS = ("left", "right")


def fill(spec: Any, problem: Pinch) -> None:
    """Writes the numbers of a pinched cube into an MjSpec of pinch.xml. The frame is the hand's:
    the hand's acceleration is part of gravity."""
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


def observe(problem: Pinch, qpos: Array, qvel: Array) -> Signals:
    """Returns the slip of the cube along the load, and its rate."""
    down, across = problem.pull / problem.load
    return {
        "slip": across * qpos[:, 0] - down * qpos[:, 2],
        "speed": across * qvel[:, 0] - down * qvel[:, 2],
    }


def controls(problem: Pinch) -> Controls:
    """Returns the forces of the fingers [N]."""
    return lambda times: np.full((len(times), 2), float(problem.normal_force))


MODEL = ModelFile(fill, observe, controls=controls)
