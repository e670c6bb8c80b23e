"""The relation of a cube on an incline to incline.xml."""

from __future__ import annotations

import math
from typing import Any

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.incline import Incline
from plumbob.models.model_file import ModelFile


def fill(spec: Any, problem: Incline) -> None:
    """Writes the numbers of a cube into an MjSpec of incline.xml. The plane is level; gravity is
    inclined, along the heading."""
    half = problem.size / 2.0
    heading = problem.heading
    cube = spec.body("cube")
    pair = spec.pair("contact")
    along = [problem.pull * math.cos(heading), problem.pull * math.sin(heading)]
    spec.option.gravity = [*along, -problem.press]
    cube.pos = [0.0, 0.0, half]
    cube.quat = [math.cos(heading / 2.0), 0.0, 0.0, math.sin(heading / 2.0)]
    cube.mass = problem.mass
    cube.inertia = [problem.mass * problem.size**2 / 6.0] * 3
    spec.geom("cube").size = [half] * 3
    pair.friction[:2] = [problem.friction] * 2
    pair.condim = 3 if problem.friction else 1
    spec.key("start").qvel = [problem.speed, 0.0, 0.0]


def observe(problem: Incline, qpos: Array, qvel: Array) -> Signals:
    """Returns the place down the plane, and the speed."""
    return {"x": qpos[:, 0], "speed": qvel[:, 0]}


MODEL = ModelFile(fill, observe)
