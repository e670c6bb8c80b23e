"""MuJoCo's reading of bodies, joints and contacts in a model file: the reference for other
readers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.engines.abilities import Fields
from plumbob.engines.adapters.mujoco.user_file import compiled_model

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
    for i in range(1, model.nbody):
        if (name := model.body(i).name) and model.body_mass[i] > 0.0:
            yield "mass", name, model.body_mass[i]
            yield "inertia", name, np.sort(model.body_inertia[i])
    one_degree = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
    for i in np.flatnonzero(np.isin(model.jnt_type, one_degree)).tolist():
        if name := model.joint(i).name:
            dof = model.jnt_dofadr[i]
            yield "armature", name, model.dof_armature[dof]
            yield "damping", name, model.dof_damping[dof]
            yield "stiffness", name, model.jnt_stiffness[i]
            yield "frictionloss", name, model.dof_frictionloss[dof]
    for kind, count in (("geom", model.ngeom), ("pair", model.npair)):
        for i in range(count):
            touches = kind == "pair" or model.geom_contype[i] or model.geom_conaffinity[i]
            if (name := getattr(model, kind)(i).name) and touches:
                for field in CONTACTS:
                    values = getattr(model, f"{kind}_{field}")[i]
                    yield field, name, values[0] if field == "friction" else values
    for i in range(model.nu):
        if name := model.actuator(i).name:
            yield "gear", name, model.actuator_gear[i, 0]
