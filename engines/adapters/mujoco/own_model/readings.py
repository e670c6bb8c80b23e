"""What is read of a MuJoCo model's states beside its motion: energy, penetration, violations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array

ENERGY, MOMENTUM, DEPTH, SLIP = "energy", "momentum", "penetration", "slip"
LIMITS, EQUALITIES = "limits exceeded", "equalities missed"


def touching(model: Any, data: Any, states: Array) -> Mapping[str, Array]:
    """{pair of geoms: in which of `states`, shape (n, ...), it touches, shape (n,)}."""
    found: dict[str, Array] = {}
    for k, state in enumerate(states):
        if np.isfinite(state).all():
            data.qpos[:] = state[: model.nq]
            mujoco.mj_fwdPosition(model, data)
            for pair in data.contact.geom[data.contact.dist <= 0.0]:
                name = pair_name(model, pair)
                found.setdefault(name, np.zeros(len(states), bool))[k] = True
    return found


def pair_name(model: Any, pair: Any) -> str:
    """The two geoms of a contact by their names."""
    return " – ".join(model.geom(int(i)).name or f"geom {i}" for i in pair if i >= 0)


def readings(model: Any, data: Any, states: Array) -> Mapping[str, Array]:
    """Of each of `states`, shape (n, ...): energy [J], momentum of a model that is free [kg m/s],
    deepest penetration [m], fastest slip of geoms that touch [m/s], the most by which a joint or
    tendon exceeds its limit and an equality is missed [m or rad]; only what the model can have, not
    numbers where a state has none, each of shape (n,)."""
    kinds = mujoco.mjtConstraint
    limits = (int(kinds.mjCNSTR_LIMIT_JOINT), int(kinds.mjCNSTR_LIMIT_TENDON))
    names = (ENERGY, MOMENTUM, DEPTH, SLIP, LIMITS, EQUALITIES)
    found = {name: np.full(len(states), np.nan) for name in names}
    for k, state in enumerate(states):
        if not np.isfinite(state).all():
            continue
        data.qpos[:], data.qvel[:] = state[: model.nq], state[model.nq : model.nq + model.nv]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        found[ENERGY][k] = data.energy.sum()
        mujoco.mj_subtreeVel(model, data)
        found[MOMENTUM][k] = np.linalg.norm(data.subtree_linvel[0]) * model.body_subtreemass[0]
        found[SLIP][k] = _slip(model, data)
        found[DEPTH][k] = max([0.0, *(-data.contact.dist)])
        types, places = data.efc_type, data.efc_pos
        found[LIMITS][k] = max([0.0, *(-places[np.isin(types, limits)])])
        found[EQUALITIES][k] = max([0.0, *np.abs(places[types == int(kinds.mjCNSTR_EQUALITY)])])
    has = {
        ENERGY: True,
        MOMENTUM: bool((model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)).any()),
        SLIP: bool(np.nanmax(found[SLIP], initial=0.0)),
        DEPTH: bool(np.nanmax(found[DEPTH], initial=0.0)),
        LIMITS: bool(np.nanmax(found[LIMITS], initial=0.0)),
        EQUALITIES: bool(model.neq),
    }
    return {name: values for name, values in found.items() if has[name]}


def _slip(model: Any, data: Any) -> float:
    """The largest speed [m/s] across the normal of two geoms that touch, 0 where none do."""
    fastest = 0.0
    one, other = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    for contact in data.contact:
        if contact.dist > 0.0 or contact.geom.min() < 0:
            continue  # not touching, or of a flex
        bodies = model.geom_bodyid[contact.geom]
        mujoco.mj_jac(model, data, one, None, contact.pos, bodies[0])
        mujoco.mj_jac(model, data, other, None, contact.pos, bodies[1])
        across = contact.frame.reshape(3, 3)[1:] @ ((other - one) @ data.qvel)
        fastest = max(fastest, float(np.linalg.norm(across)))
    return fastest
