"""Names and places of a MuJoCo model's coordinates."""

from __future__ import annotations

from typing import Any

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
