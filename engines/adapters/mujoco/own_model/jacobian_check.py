"""Check of MuJoCo's solver: its iterations must not depend on how its Jacobian is stored."""

from __future__ import annotations

import copy
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array

# Relative difference of accelerations after one iteration above which a solver counts as wrong. On
# branching trees of 32 to 69 degrees of freedom on a plane MuJoCo 3.17.0 differs by 4e-14 at most,
# which is rounding; the wrong Hessian of 4.0.0 makes 8e-3 and more of it.
WRONG_SOLVER = 1e-6
STATE_ARRAYS = ("qpos", "qvel", "act", "ctrl", "mocap_pos", "mocap_quat", "qfrc_applied")


def jacobian_note(model: Any, start: Any) -> str:
    """Returns a note if the first iteration of the solver at the state `start` with a sparse
    Jacobian, which the model's steps use, is not that with a dense one; empty if they agree, or if
    no constraint acts."""
    if not mujoco.mj_isSparse(model) or not start.nefc:
        return ""
    dense = accelerations(model, start, mujoco.mjtJacobian.mjJAC_DENSE)
    sparse = accelerations(model, start, mujoco.mjtJacobian.mjJAC_SPARSE)
    largest = max(float(np.abs(dense).max()), float(np.abs(sparse).max()))
    difference = float(np.abs(dense - sparse).max())
    if difference <= WRONG_SOLVER * largest:
        return ""
    return (
        f"MuJoCo {mujoco.__version__} has a wrong solver for this model: with a sparse Jacobian "
        f"its first iteration is {100.0 * difference / largest:.2g} % off: more are needed, or "
        'accelerations stay wrong; set jacobian="dense" in <option>, or use another release'
    )


def accelerations(model: Any, start: Any, form: mujoco.mjtJacobian) -> Array:
    """Returns the generalised accelerations at a state after one iteration of the solver, with a
    form of the Jacobian."""
    changed = copy.copy(model)
    changed.opt.jacobian = form
    changed.opt.iterations = 1
    data = mujoco.MjData(changed)
    for name in STATE_ARRAYS:
        getattr(data, name)[:] = getattr(start, name)
    mujoco.mj_forward(changed, data)
    return np.array(data.qacc)
