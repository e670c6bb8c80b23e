"""Names and places of a MuJoCo model's coordinates, and models without some of what a file says, to
recognise what another engine drops."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.terms import MujocoTerms
from plumbob.engines.peer_model import Joint, Layout

SIZES = (6, 3, 1, 1)  # degrees of freedom by kind of joint
COORDINATES = (7, 4, 1, 1)


def layout(model: Any) -> Layout:
    """Names of the joints and actuators of the compiled `model`, and where coordinates are."""
    joints = (
        Joint(
            model.joint(i).name,
            SIZES[kind],
            int(model.jnt_qposadr[i]),
            int(model.jnt_dofadr[i]),
            model.qpos0[model.jnt_qposadr[i] :][: COORDINATES[kind]],
        )
        for i, kind in enumerate(model.jnt_type)
    )
    actuators = (model.actuator(i).name for i in range(model.nu))
    return Layout(tuple(joints), tuple(actuators), _moving(model))


def _moving(model: Any) -> tuple[str, ...]:
    """Names of the bodies that move."""
    return tuple(
        model.body(i).name
        for i in range(model.nbody)
        if model.body_weldid[i] and model.body(i).name
    )


def of_gravity(model: Any, data: Any, state: Array) -> Array:
    """Generalised forces [N, N m] of a gravity of 1 m/s^2 along each axis, shape (nv, 3)."""
    model, columns = copy.copy(model), []
    model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
    for axis in np.eye(3):
        model.opt.gravity[:] = axis
        columns.append(MujocoTerms(model, data)(state, data.ctrl)["gravity"])
    return np.stack(columns, axis=1)


def suspects(model: Any) -> Iterator[tuple[str, Any]]:
    """The parts that an engine may drop of the compiled `model`, and the model without it."""

    def without(**fields: Any) -> Any:
        other = copy.copy(model)
        for name, value in fields.items():
            getattr(other, name)[:] = value
        return other

    joints = mujoco.mjtTrn.mjTRN_JOINT
    driven = np.isin(
        model.dof_jntid, model.actuator_trnid[model.actuator_trntype == int(joints), 0]
    )
    yield "armature", without(dof_armature=0.0)
    yield "armature where there is no actuator", without(dof_armature=model.dof_armature * driven)
    yield "springs", without(jnt_stiffness=0.0)
    yield "damping", without(dof_damping=0.0)
    yield "springs and damping", without(jnt_stiffness=0.0, dof_damping=0.0)
    gear = np.zeros_like(model.actuator_gear)
    gear[:, 0] = 1.0
    yield "gear", without(actuator_gear=gear)
    yield "actuators", without(actuator_gainprm=0.0, actuator_biasprm=0.0)
