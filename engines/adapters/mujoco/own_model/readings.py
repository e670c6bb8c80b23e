"""Readings of a MuJoCo model's states beside its motion: energy, penetration, violations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array

ENERGY, MOMENTUM, DEPTH, SLIP = "energy", "momentum", "penetration", "slip"
LIMITS, EQUALITIES = "limits exceeded", "equalities missed"
KINDS = mujoco.mjtConstraint
LIMIT_KINDS = (KINDS.mjCNSTR_LIMIT_JOINT, KINDS.mjCNSTR_LIMIT_TENDON)
DEEP = 0.01  # [m or rad] of contacts, and beyond limits, that a start is hardly meant to have


def pair_name(model: Any, pair: Any) -> str:
    """The two geoms of a contact by their names."""
    return " – ".join(model.geom(int(i)).name or f"geom {i}" for i in pair if i >= 0)


def readings(model: Any, data: Any, states: Array) -> Mapping[str, Array]:
    """Of each of `states`, shape (n, ...): energy [J], momentum of a model that is free [kg m/s],
    deepest penetration [m], fastest slip of geoms that touch [m/s], the most by which a joint or
    tendon exceeds its limit and an equality is missed [m or rad]; only what the model can have, NaN
    where a state has none, each of shape (n,)."""
    names = (ENERGY, MOMENTUM, DEPTH, SLIP, LIMITS, EQUALITIES)
    measured = {name: np.full(len(states), np.nan) for name in names}
    for k, state in enumerate(states):
        if not np.isfinite(state).all():
            continue
        data.qpos[:], data.qvel[:] = state[: model.nq], state[model.nq : model.nq + model.nv]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        measured[ENERGY][k] = data.energy.sum()
        mujoco.mj_subtreeVel(model, data)
        measured[MOMENTUM][k] = np.linalg.norm(data.subtree_linvel[0]) * model.body_subtreemass[0]
        measured[SLIP][k] = _slip(model, data)
        measured[DEPTH][k] = max([0.0, *(-data.contact.dist)])
        measured[LIMITS][k] = max([0.0, *(-_places(data, *LIMIT_KINDS))])
        measured[EQUALITIES][k] = max([0.0, *np.abs(_places(data, KINDS.mjCNSTR_EQUALITY))])
    has = {
        ENERGY: True,
        MOMENTUM: bool((model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)).any()),
        SLIP: bool(np.nanmax(measured[SLIP], initial=0.0)),
        DEPTH: bool(np.nanmax(measured[DEPTH], initial=0.0)),
        LIMITS: bool(np.nanmax(measured[LIMITS], initial=0.0)),
        EQUALITIES: bool(model.neq),
    }
    return {name: values for name, values in measured.items() if has[name]}


def unlikely(start: Any) -> tuple[str, ...]:
    """Warnings about a `start`, an mjData whose constraints are known: geoms deep inside each
    other, limits far exceeded."""
    depth = max([0.0, *(-start.contact.dist)])
    beyond = max([0.0, *(-_places(start, *LIMIT_KINDS))])
    what = [f"contacts {depth:.2g} m deep"] if depth > DEEP else []
    what += [f"limits exceeded by {beyond:.2g} m or rad"] if beyond > DEEP else []
    return (f"it starts with {' and '.join(what)}: is that posture meant?",) if what else ()


def _places(data: Any, *kinds: Any) -> Array:
    """Distances [m or rad] of the constraints of some kinds, shape (n,)."""
    return np.asarray(data.efc_pos[np.isin(data.efc_type, [int(kind) for kind in kinds])])


def _slip(model: Any, data: Any) -> float:
    """The largest speed [m/s] across the normal of two geoms that touch, 0 where none do."""
    fastest = 0.0
    first, other = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    for contact in data.contact:
        if contact.dist > 0.0 or contact.geom.min() < 0:
            continue  # not touching, or of a flex
        bodies = model.geom_bodyid[contact.geom]
        mujoco.mj_jac(model, data, first, None, contact.pos, bodies[0])
        mujoco.mj_jac(model, data, other, None, contact.pos, bodies[1])
        across = contact.frame.reshape(3, 3)[1:] @ ((other - first) @ data.qvel)
        fastest = max(fastest, float(np.linalg.norm(across)))
    return fastest
