"""MuJoCo's reading of bodies, joints and contacts in a model file: the reference for other
readers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from plumbob.engines.abilities import ModelFields
from plumbob.engines.adapters.mujoco.user_file import compiled_model

SCALARS = ("armature", "damping", "stiffness", "frictionloss")


def model_fields(path: Path) -> ModelFields:
    """The numbers of the model file `path`, of everything in it that has a name: gravity
    [m/s^2], time step [s], masses [kg], principal moments of inertia [kg m^2], of hinges and slides
    armature, damping, stiffness and friction loss, of geoms that may touch, and of pairs, the
    coefficient of friction, solref and solimp, and gears. Raises ParameterError."""
    import mujoco

    model = compiled_model(path, "FILE")
    fields: dict[tuple[str, str], tuple[float, ...]] = {
        ("gravity", ""): tuple(model.opt.gravity.tolist()),
        ("timestep", ""): (float(model.opt.timestep),),
    }
    for i in range(1, model.nbody):
        if (body := model.body(i)).name and model.body_mass[i] > 0.0:
            fields["mass", body.name] = (float(model.body_mass[i]),)
            fields["inertia", body.name] = tuple(np.sort(model.body_inertia[i]).tolist())
    one_degree = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
    for i in range(model.njnt):
        joint, dof = model.joint(i), int(model.jnt_dofadr[i])
        if not joint.name or int(model.jnt_type[i]) not in one_degree:
            continue
        values = (
            model.dof_armature[dof],
            model.dof_damping[dof],
            model.jnt_stiffness[i],
            model.dof_frictionloss[dof],
        )
        for field, value in zip(SCALARS, values, strict=True):
            fields[field, joint.name] = (float(value),)
    for i in range(model.ngeom):
        if model.geom(i).name and (model.geom_contype[i] or model.geom_conaffinity[i]):
            name = model.geom(i).name
            fields["friction", name] = (float(model.geom_friction[i, 0]),)
            fields["solref", name] = tuple(model.geom_solref[i].tolist())
            fields["solimp", name] = tuple(model.geom_solimp[i].tolist())
    for i in range(model.npair):
        if name := model.pair(i).name:
            fields["friction", name] = (float(model.pair_friction[i, 0]),)
            fields["solref", name] = tuple(model.pair_solref[i].tolist())
            fields["solimp", name] = tuple(model.pair_solimp[i].tolist())
    for i in range(model.nu):
        if model.actuator(i).name:
            fields["gear", model.actuator(i).name] = (float(model.actuator_gear[i, 0]),)
    return fields
