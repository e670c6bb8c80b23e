"""Readings of a MuJoCo model's states beside its motion: energy, penetration, violations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.terms import put

NAMES = ("energy", "penetration", "limits exceeded", "equalities missed")
KINDS = mujoco.mjtConstraint
LIMITS = (int(KINDS.mjCNSTR_LIMIT_JOINT), int(KINDS.mjCNSTR_LIMIT_TENDON))
DEEP = 0.01  # [m or rad] of contacts, and beyond limits, that a start is hardly meant to have


def pair_name(model: Any, pair: Any) -> str:
    """The two geoms of a contact by their names."""
    return " – ".join(model.geom(int(i)).name or f"geom {i}" for i in pair if i >= 0)


def readings(model: Any, data: Any, states: Array) -> Mapping[str, Array]:
    """Of each of `states`, shape (n, ...): energy [J], deepest penetration [m], the most by which a
    joint or tendon exceeds its limit and an equality is missed [m or rad]; only what some state
    has, NaN where one has none, each of shape (n,)."""
    measured = np.full((len(NAMES), len(states)), np.nan)
    for k, state in enumerate(states):
        if np.isfinite(state).all():
            put(data, state)
            mujoco.mj_fwdPosition(model, data)
            mujoco.mj_fwdVelocity(model, data)
            mujoco.mj_energyPos(model, data)
            mujoco.mj_energyVel(model, data)
            missed = np.abs(_places(data, int(KINDS.mjCNSTR_EQUALITY))).max(initial=0.0)
            measured[:, k] = data.energy.sum(), *_beyond(data), missed
    has = np.nanmax(np.abs(measured), axis=1, initial=0.0) > 0.0
    return {name: of for name, of, some in zip(NAMES, measured, has, strict=True) if some}


def unlikely(start: Any) -> tuple[str, ...]:
    """Warnings about a `start`, an mjData whose constraints are known: geoms deep inside each
    other, limits far exceeded."""
    depth, beyond = _beyond(start)
    what = [f"contacts {depth:.2g} m deep"] if depth > DEEP else []
    what += [f"limits exceeded by {beyond:.2g} m or rad"] if beyond > DEEP else []
    return (f"it starts with {' and '.join(what)}: is that posture meant?",) if what else ()


def _beyond(data: Any) -> tuple[float, float]:
    """The deepest penetration [m], and the most by which a limit is exceeded [m or rad]."""
    return -data.contact.dist.min(initial=0.0), -_places(data, *LIMITS).min(initial=0.0)


def _places(data: Any, *kinds: int) -> Array:
    """Distances [m or rad] of the constraints of some kinds, shape (n,)."""
    return np.asarray(data.efc_pos[np.isin(data.efc_type, kinds)])
