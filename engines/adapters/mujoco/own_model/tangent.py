"""The steps of a MuJoCo model beside neighbouring ones: Jacobians of a step, growth of a nudge.

The tangent space of a model is that of its positions (`mj_integratePos`, `mj_differentiatePos`),
beside velocities and activations.
"""

from __future__ import annotations

import copy
import math
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.own_model.field import converging
from plumbob.engines.adapters.mujoco.own_model.left_out import apply
from plumbob.engines.adapters.mujoco.own_model.places import place
from plumbob.engines.own_motion import Change, Place, Script

# [m, rad, ...] of the state, along a direction by chance. An unstable contact chatters: a
# nudge's growth ends where it opens, at some 1e-5 m, which is to be more than a thousandfold.
NUDGE = 1e-9
_BAD = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
)


def kind(integrator: str) -> Any:
    """MuJoCo's number of an integrator."""
    return getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")


def put(data: Any, state: Array) -> None:
    """Give an mjData a state: qpos, qvel, act."""
    nq, nv = data.qpos.size, data.qvel.size
    data.qpos[:], data.qvel[:], data.act[:] = np.split(state, (nq, nq + nv))


def diverged(data: Any) -> bool:
    """Whether MuJoCo has warned of numbers without bounds, or some are none."""
    warned = any(data.warning[bad].number for bad in _BAD)
    return warned or not np.isfinite(data.qpos).all()


class TangentMaps:
    """Jacobians of one step of a model from the state and control of an mjData; a `StepMaps`. The
    constraint solver runs to its floor, always from the same forces, so that a step is a function
    of its state alone."""

    def __init__(self, model: Any, data: Any, state: Array, control: Array) -> None:
        """The model is one of `for_maps`, which all that share it leave as it is but for its step
        and integrator."""
        self.model, self.data, self.state, self.control = model, data, state, control
        put(data, state)
        data.ctrl[:] = control
        self.about = data.qpos.copy(), data.qvel.copy(), data.act.copy()
        mujoco.mj_forward(model, data)
        self.warm = data.qacc.copy()
        self.size = 2 * model.nv + model.na

    def __call__(
        self, integrator: str, step: float, difference: float, directions: Array | None = None
    ) -> Array:
        """See `StepMaps`."""
        model, nv = self.model, self.model.nv
        model.opt.timestep, model.opt.integrator = step, kind(integrator)
        wanted = np.eye(self.size) if directions is None else directions.T
        derivatives = np.zeros(wanted.shape)
        for derivative, direction in zip(derivatives, difference * wanted, strict=True):
            ahead, velocity, activation = self._stepped(direction)
            behind, other_velocity, other_activation = self._stepped(-direction)
            mujoco.mj_differentiatePos(model, derivative[:nv], 1.0, behind, ahead)
            derivative[nv : 2 * nv] = velocity - other_velocity
            derivative[2 * nv :] = activation - other_activation
        return derivatives.T / (2.0 * difference)

    def _stepped(self, shift: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities and activations a step after a shift of the state."""
        data, nv = self.data, self.model.nv
        data.qpos[:], data.qvel[:], data.act[:] = self.about
        data.qacc_warmstart[:] = self.warm
        mujoco.mj_integratePos(self.model, data.qpos, shift[:nv], 1.0)
        data.qvel += shift[nv : 2 * nv]
        data.act += shift[2 * nv :]
        mujoco.mj_step(self.model, data)
        return data.qpos.copy(), data.qvel.copy(), data.act.copy()

    def place(self, weights: Array) -> Place:
        """See `StepMaps`."""
        put(self.data, self.state)
        mujoco.mj_forward(self.model, self.data)
        return place(self.model, self.data, weights)

    def changed(self, change: Change) -> TangentMaps:
        """See `StepMaps`."""
        model = copy.copy(self.model)
        apply(model, (change,))
        return TangentMaps(model, self.data, self.state, self.control)


def for_maps(model: Any) -> Any:
    """The model for Jacobians of its steps, changed in place: its solver runs to its floor, and it
    goes on from numbers without bounds."""
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    converging(model).opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_WARMSTART)
    return model


def growth(model: Any, pair: tuple[Any, Any], script: Script, begin: int, duration: float) -> float:
    """How many times as far apart as a nudge of the start of `script` are positions, at most, when
    `model` has stepped for a `duration` [s]; its controls are those from the period `begin` on,
    then the last one. `pair` are the two mjData; infinite where one diverges."""
    nudge = np.random.default_rng(0).standard_normal(2 * model.nv + model.na)
    nudge *= NUDGE / np.abs(nudge).max()
    for data in pair:
        put(data, script.start)
    mujoco.mj_integratePos(model, pair[1].qpos, nudge[: model.nv], 1.0)
    pair[1].qvel += nudge[model.nv : 2 * model.nv]
    pair[1].act += nudge[2 * model.nv :]
    apart, largest = np.zeros(model.nv), 0.0
    for k in range(math.ceil(duration / model.opt.timestep)):
        period = begin + int((k + 1e-6) * model.opt.timestep / script.period)
        for data in pair:
            data.ctrl[:] = script.controls[min(period, len(script.controls) - 1)]
            mujoco.mj_step(model, data)
        if any(diverged(data) for data in pair):
            return math.inf
        mujoco.mj_differentiatePos(model, apart, 1.0, pair[0].qpos, pair[1].qpos)
        largest = max(largest, float(np.abs(apart).max()))
    return largest / NUDGE
