"""Derivatives of a run's end by `mjd_transitionFD`, multiplied along the run.

With the state x in tangent coordinates and the control u of each step, x_n+1 = f(x_n, u_n), and the
derivatives A = f_x and B = f_u by MuJoCo's own central differences,

    dx_n+1/dp = A_n dx_n/dp + B_n du_n/dp,     of p in the start and in the controls.

Their rounding is a unit in the last place of a state over NUDGE in each step: 1e-8 of the
derivative, calibrated in tests/gradients. In the step in which a support begins to slip it is
slower than NUDGE, which turns its friction round: with contacts the differences are TOUCHING, at
which rounding is smaller than that. On capsule-turn/pivot at 0.15 to 1 ms the product is then
within 1e-4 of the run's derivative, and up to 5e-3 off with NUDGE.
"""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.simulation import MujocoSimulation, compiled
from plumbob.engines.adapters.mujoco.translation import Translation
from plumbob.engines.adapters.own_derivatives import NUDGE, moved, nudged
from plumbob.engines.method import Method, Unsupported
from plumbob.models.gradient import Number

TOUCHING = 1e-7  # of a state's number


def transition(number: Number, method: Method, step: float) -> Mapping[str, float]:
    """Derivatives of the observables that a state gives; raises Unsupported."""
    cases, apart = nudged(number)
    low, here, high = (compiled(case, method, step) for case in cases)
    if here.model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        raise Unsupported("mjd_transitionFD refuses RK4")
    if _numbers(low.model) != _numbers(high.model):
        raise Unsupported(
            f"mjd_transitionFD has derivatives by state and control: {number.name} "
            "is a parameter of the model"
        )
    with options.collected():  # warnings are those of the run itself
        return _multiplied(low, here, high, apart)


def _numbers(model: mujoco.MjModel) -> bytes:
    """All numbers of a model but its keyframes."""
    held = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    model.key_qpos[:], model.key_qvel[:] = 0.0, 0.0
    mujoco.mj_saveModel(model, None, held)
    return held.tobytes()


def _multiplied(
    low: MujocoSimulation, here: MujocoSimulation, high: MujocoSimulation, apart: float
) -> Mapping[str, float]:
    model, data, translation = here.model, here.data, here.translation
    indices = np.arange(here.steps, dtype=np.int64)
    nudge = TOUCHING if model.ngeom else NUDGE
    held, changes = (
        here.held_controls(indices),
        (high.held_controls(indices) - low.held_controls(indices)) / apart,
    )
    along = _at_start(model, low.translation, high.translation, apart)
    by_state, by_control = np.zeros((along.size,) * 2), np.zeros((along.size, model.nu))
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.qvel[:] = translation.qpos, translation.qvel
    for control, change in zip(held, changes, strict=True):
        data.ctrl[:] = control
        mujoco.mjd_transitionFD(model, data, nudge, True, by_state, by_control, None, None)
        along = by_state @ along + by_control @ change
        mujoco.mj_step(model, data)
    return _read(here, along)


def _at_start(model: mujoco.MjModel, low: Translation, high: Translation, apart: float) -> Array:
    """The derivative of the state that runs start in."""
    along = np.zeros(2 * model.nv + model.na)
    mujoco.mj_differentiatePos(model, along[: model.nv], apart, low.qpos, high.qpos)
    along[model.nv : 2 * model.nv] = (high.qvel - low.qvel) / apart
    return along


def _read(here: MujocoSimulation, along: Array) -> Mapping[str, float]:
    """The derivatives of the observables in a state that changes `along` a tangent."""
    model, data = here.model, here.data

    def observe(side: float) -> Mapping[str, Array]:
        qpos, qvel = data.qpos.copy(), data.qvel + side * along[model.nv : 2 * model.nv]
        mujoco.mj_integratePos(model, qpos, along[: model.nv], side)
        return here.translation.observe(qpos[None], qvel[None])[0]

    return moved(observe, along)
