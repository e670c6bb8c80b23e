"""The stack in MuJoCo's terms: a slide along z a cube, and a contact a corner."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.errors.contact_models.held_bodies import corners
from plumbob.analytic.errors.contact_models.soft_friction import rates
from plumbob.engines.adapters.mujoco import contacts
from plumbob.engines.adapters.mujoco.translation import Translation, read, with_contacts
from plumbob.engines.method import Method, ModelError

scheme = contacts.scheme


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a Stack at the static depths of its contacts."""
    spec = whole(mjcf, problem)
    profile = contacts.profile(method.settings)
    tune = with_contacts(spec, profile, step)
    depths = np.cumsum([profile.depth(held, step) for held in corners(problem)])
    return Translation(
        spec,
        -depths,
        np.zeros(len(depths)),
        lambda qpos, qvel: ({"top": qpos[:, -1]}, {}),
        tune=tune,
    )


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Where the solver ends: by an acceleration of each cube, which its contact's stiffness turns
    into a depth."""
    profile = contacts.profile(method.settings)
    if (point := profile.point) is None:
        return {}
    off = math.sqrt(2.0 * float(profile.options.get("tolerance", contacts.SOLVED)))
    masses = problem.masses
    left = off * np.sqrt(masses.sum() / masses).sum() / rates(point, step)[0]
    return {"top": {"solver": float(left)}}


def whole(mjcf: Path, problem: Any) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, visual parts included."""
    spec = read(mjcf, problem.gravity)
    half = problem.size / 2.0
    # pairs first: MuJoCo deletes those of a body with it
    for part in (*spec.keys, *spec.pairs, *spec.bodies[1:]):
        spec.delete(part)
    below = "ground"
    for i, mass in enumerate(problem.masses):
        cube = spec.worldbody.add_body(name=f"cube_{i}", pos=[0.0, 0.0, half * (2 * i + 1)])
        cube.add_joint(name=f"z_{i}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0.0, 0.0, 1.0])
        cube.mass = mass
        cube.inertia = [mass * problem.size**2 / 6.0] * 3
        cube.explicitinertial = True
        cube.ipos = [0.0] * 3
        cube.iquat = [1.0, 0.0, 0.0, 0.0]
        name = f"cube_{i}"
        cube.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_BOX, size=[half] * 3)
        spec.add_pair(geomname1=below, geomname2=name, condim=1)
        below = name
    spec.add_key(name="start", qpos=[0.0] * problem.count)
    return spec
