"""MuJoCo's reading of bodies, joints and contacts in a model file: the reference for other
readers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.engines.abilities import Fields
from plumbob.engines.adapters.mujoco.user_file import compiled_model

JOINTS = ("armature", "damping", "stiffness", "frictionloss")
CONTACTS = ("friction", "solref", "solimp")


def model_fields(path: Path) -> Fields:
    """The numbers of the model file `path`, of everything in it that has a name: gravity
    [m/s^2], time step [s], masses [kg], principal moments of inertia [kg m^2], of hinges and slides
    armature, damping, stiffness and friction loss, of geoms that may touch, and of pairs, the
    coefficient of friction, solref and solimp, and gears. Raises ParameterError."""
    yield from fields_in(compiled_model(path, "FILE"))


def fields_in(model: Any) -> Fields:
    """Those of a compiled model."""
    yield "gravity", "", model.opt.gravity
    yield "timestep", "", model.opt.timestep
    for body in map(model.body, range(1, model.nbody)):
        if body.name and body.mass > 0.0:
            yield "mass", body.name, body.mass[0]
            yield "inertia", body.name, np.sort(body.inertia)
    one_degree = [int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)]
    for joint in map(model.joint, range(model.njnt)):
        if joint.name and joint.type[0] in one_degree:
            for field in JOINTS:
                yield field, joint.name, getattr(joint, field)[0]
    geoms = map(model.geom, range(model.ngeom))
    touching = [geom for geom in geoms if geom.contype or geom.conaffinity]
    for part in (*touching, *map(model.pair, range(model.npair))):
        if part.name:
            for field in CONTACTS:
                values = getattr(part, field)
                yield field, part.name, values[0] if field == "friction" else values
    for actuator in map(model.actuator, range(model.nu)):
        if actuator.name:
            yield "gear", actuator.name, actuator.gear[0]
