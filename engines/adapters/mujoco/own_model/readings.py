"""What is read of a MuJoCo model's states beside its motion: energy, penetration, violations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array

ENERGY, DEPTH, LIMITS, EQUALITIES = "energy", "penetration", "limits exceeded", "equalities missed"


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
    """Of each of `states`, shape (n, ...): energy [J], deepest penetration [m], the most by which a
    joint or tendon exceeds its limit and an equality is missed [m or rad]; only what the model can
    have, not numbers where a state has none, each of shape (n,)."""
    kinds = mujoco.mjtConstraint
    limits = (int(kinds.mjCNSTR_LIMIT_JOINT), int(kinds.mjCNSTR_LIMIT_TENDON))
    found = {name: np.full(len(states), np.nan) for name in (ENERGY, DEPTH, LIMITS, EQUALITIES)}
    for k, state in enumerate(states):
        if not np.isfinite(state).all():
            continue
        data.qpos[:], data.qvel[:] = state[: model.nq], state[model.nq : model.nq + model.nv]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        found[ENERGY][k] = data.energy.sum()
        found[DEPTH][k] = max([0.0, *(-data.contact.dist)])
        types, places = data.efc_type, data.efc_pos
        found[LIMITS][k] = max([0.0, *(-places[np.isin(types, limits)])])
        found[EQUALITIES][k] = max([0.0, *np.abs(places[types == int(kinds.mjCNSTR_EQUALITY)])])
    has = {
        ENERGY: True,
        DEPTH: bool(np.nanmax(found[DEPTH], initial=0.0)),
        LIMITS: bool(np.nanmax(found[LIMITS], initial=0.0)),
        EQUALITIES: bool(model.neq),
    }
    return {name: values for name, values in found.items() if has[name]}
