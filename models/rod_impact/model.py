"""The relation of a falling rod to rod_impact.xml."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.rod_impact import RodImpact
from plumbob.models.idealisations import Idealisations
from plumbob.models.model_file import ModelFile


def fill(spec: Any, problem: RodImpact) -> None:
    """Writes the numbers of a rod into an MjSpec of rod_impact.xml, but not the springs and dampers
    of its contacts: these depend on the step."""
    half = problem.length / 2.0
    rod = spec.body("rod")
    start = spec.key("start")
    at_start = problem.observe(np.zeros(1))
    spec.option.gravity = [0.0, 0.0, -problem.gravity]
    rod.mass = problem.mass
    rod.inertia = [problem.mass * problem.length**2 / 12.0] * 3
    spec.geom("rod").fromto = [-half, 0.0, 0.0, half, 0.0, 0.0]
    for side, pair in zip((-half, half), spec.pairs, strict=True):
        spec.geom(pair.geomname2).pos = [side, 0.0, 0.0]
        pair.friction[:2] = [problem.friction] * 2
        pair.condim = 3 if problem.friction else 1
    start.qpos = [at_start[name][0] for name in ("x", "z", "angle")]
    start.qvel = [problem.speed, 0.0, 0.0]


def ideal(problem: RodImpact) -> Idealisations:
    """Returns the idealisation: both ends bounce."""
    return Idealisations(restitution={"low": problem.restitution, "high": problem.restitution})


def observe(problem: RodImpact, qpos: Array, qvel: Array) -> Signals:
    """Returns the place of the centre, and the angle."""
    return dict(zip(("x", "z", "angle"), qpos.T, strict=True))


MODEL = ModelFile(fill, observe, ideal)
