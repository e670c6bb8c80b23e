"""A chain of rods in MuJoCo's terms: the model's file with as many rods as a problem has."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.engines.adapters.mujoco.translation import Translation, of_system, read
from plumbob.engines.method import Method


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate an NPendulum."""
    return of_chain(whole(mjcf, problem), problem.motion.system)


def of_chain(spec: mujoco.MjSpec, system: SmoothSystem) -> Translation:
    """The translation of a chain's model; a hinge's angle is that from the rod above."""
    return of_system(spec, system, lambda joints: np.cumsum(joints, axis=1))


def whole(mjcf: Path, problem: Any) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, visual parts included."""
    spec = read(mjcf, problem.gravity)
    above = None
    end = 0.0
    rods = zip(problem.each("masses"), problem.each("lengths"), strict=True)
    for number, (mass, length) in enumerate(rods, start=1):
        rod = spec.body(f"rod_{number}") or _added(above, number)
        rod.pos = [0.0, 0.0, -end]
        rod.mass = mass
        rod.ipos = [0.0, 0.0, -length / 2]
        rod.inertia = [mass * length**2 / 12] * 3
        rod.first_geom().fromto = [0.0, 0.0, 0.0, 0.0, 0.0, -length]
        above, end = rod, length
    if (further := spec.body(f"rod_{len(problem.angles) + 1}")) is not None:
        spec.delete(further)
    start = spec.key("start")
    start.qpos = np.diff(problem.each("angles"), prepend=0.0)
    start.qvel = np.diff(problem.each("angular_velocities"), prepend=0.0)
    return spec


def _added(above: Any, number: int) -> Any:
    rod = above.add_body(name=f"rod_{number}")
    rod.add_joint(name=f"hinge_{number}", axis=[0.0, -1.0, 0.0])
    rod.add_geom(type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[0.015, 0.0, 0.0], mass=0.0)
    rod.explicitinertial = True
    return rod
