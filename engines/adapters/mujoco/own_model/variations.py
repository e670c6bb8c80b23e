"""Other ways to compute the motion of a user's model: with another Jacobian, solver or flag, and in
a batch on several threads."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
from mujoco import rollout

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.own_model.field import with_converging_solver
from plumbob.engines.adapters.mujoco.own_model.user_stepper import like_start
from plumbob.engines.adapters.mujoco.stepper import PHYSICS
from plumbob.engines.adapters.mujoco.terms import put, state_of
from plumbob.engines.own_motion import VariationKind

SOLVERS = ("PGS", "CG", "Newton")
Changed = tuple[str, VariationKind, Any, Any]
"""A name, a kind, a compiled model, and the compiled model whose motion it should have."""
# Name of a flag's row, its kind, its field of a model's options, and its name there. Islands were
# enabled by a flag before they were disabled by one.
FLAGS: tuple[tuple[str, VariationKind, str, str], ...] = (
    ("islands", "flag", "disableflags", "mjDSBL_ISLAND"),
    ("islands", "flag", "enableflags", "mjENBL_ISLAND"),
    ("warm start", "flag", "disableflags", "mjDSBL_WARMSTART"),
    ("sleep", "sleep", "enableflags", "mjENBL_SLEEP"),
)


def varied_models(model: Any) -> Iterator[Changed]:
    """Yields the name and kind of each changed setting, the compiled model with it, and the model
    whose motion it should have. Settings that the installed release of MuJoCo lacks are left
    out."""
    other = "dense" if mujoco.mj_isSparse(model) else "sparse"
    yield f"{other} Jacobian", "jacobian", _with_jacobian(model, other), model
    tight = with_converging_solver(copy.copy(model))
    name = f"{other} Jacobian, converged solver"
    yield name, "converged", _with_jacobian(tight, other), tight
    for solver in SOLVERS:
        number = getattr(mujoco.mjtSolver, f"mjSOL_{solver.upper()}")
        if model.opt.solver != number:
            changed = copy.copy(model)
            changed.opt.solver = number
            yield f"{solver} solver", "solver", changed, model
    for name, kind, flags, flag in FLAGS:
        kinds = mujoco.mjtDisableBit if flags == "disableflags" else mujoco.mjtEnableBit
        bit = getattr(kinds, flag, None)
        if bit is not None:
            changed = copy.copy(model)
            setattr(changed.opt, flags, getattr(model.opt, flags) ^ int(bit))
            is_set = bool(getattr(changed.opt, flags) & int(bit))
            word = "on" if is_set == (flags == "enableflags") else "off"
            yield f"{name} {word}", kind, changed, model


def _with_jacobian(model: Any, jacobian: str) -> Any:
    """Returns a copy of a compiled model with a "dense" or "sparse" Jacobian."""
    changed = copy.copy(model)
    changed.opt.jacobian = getattr(mujoco.mjtJacobian, f"mjJAC_{jacobian.upper()}")
    return changed


def batch_states(model: Any, start: Any, states: Array, controls: Array, threads: int) -> Array:
    """Returns the states of runs of a batch by `mujoco.rollout`, shape (runs, steps + 1, n), from
    `states`, shape (runs, n), under controls that all share, shape (steps, nu). Mocap poses are
    those of the mjData `start`."""
    data = [like_start(mujoco.MjData(model), start) for _ in range(threads)]
    begin = np.empty((len(states), mujoco.mj_stateSize(model, PHYSICS)))
    for row, state in zip(begin, states, strict=True):
        put(data[0], state)
        mujoco.mj_getState(model, data[0], row, PHYSICS)
    held = np.broadcast_to(controls, (len(states), *controls.shape))
    physics, _ = rollout.rollout(model, data, begin, held)
    runs = np.empty((len(states), len(controls) + 1, states.shape[1]))
    runs[:, 0] = states
    for run, rows in zip(runs, physics, strict=True):
        for number, row in enumerate(rows, 1):
            mujoco.mj_setState(model, data[0], row, PHYSICS)
            run[number] = state_of(data[0])
    return runs
