"""The terms of a MuJoCo model's equations of motion in any state, computed by MuJoCo or by a port
of MuJoCo, and the steps of a port."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.options import word
from plumbob.engines.peer_model import Layout, Terms

Forward = Callable[[Any, Any], None]
EXPLICIT = mujoco.mjtDisableBit.mjDSBL_EULERDAMP | mujoco.mjtDisableBit.mjDSBL_DAMPER
KINDS = mujoco.mjtConstraint
ACTING = (
    ("equalities", (KINDS.mjCNSTR_EQUALITY,)),
    ("friction losses", (KINDS.mjCNSTR_FRICTION_DOF, KINDS.mjCNSTR_FRICTION_TENDON)),
    ("limits", (KINDS.mjCNSTR_LIMIT_JOINT, KINDS.mjCNSTR_LIMIT_TENDON)),
)


def integrator_of(model: Any) -> str:
    """The name of a compiled model's integrator."""
    return word("integrator", model.opt.integrator)


class CompiledSteps:
    """The step and the integrator of an instance with a compiled `model`."""

    model: Any

    @property
    def step(self) -> float:
        """The model's own step [s]."""
        return float(self.model.opt.timestep)

    @property
    def integrator(self) -> str:
        """The model's own integrator."""
        return integrator_of(self.model)


def put(data: Any, state: Array) -> None:
    """Sets the state of an mjData: qpos, qvel, act."""
    nq = data.qpos.size
    nv = data.qvel.size
    data.qpos[:] = state[:nq]
    data.qvel[:] = state[nq : nq + nv]
    data.act[:] = state[nq + nv :]


def state_of(data: Any) -> Array:
    """The state of an mjData: qpos, qvel, act."""
    return np.concatenate([data.qpos, data.qvel, data.act])


def shifted(model: Any, state: Array, shift: Array) -> Array:
    """A state moved by a `shift` in tangent coordinates, shape (2 nv + na,)."""
    nv = model.nv
    moved = state.copy()
    mujoco.mj_integratePos(model, moved[: model.nq], shift[:nv], 1.0)
    moved[model.nq :] += shift[nv:]
    return moved


def apart(model: Any, state: Array, other: Array) -> Array:
    """The shift in tangent coordinates from `other` to `state`, shape (2 nv + na,)."""
    nq = model.nq
    nv = model.nv
    shift = np.concatenate([np.zeros(nv), state[nq:] - other[nq:]])
    mujoco.mj_differentiatePos(model, shift[:nv], 1.0, other[:nq], state[:nq])
    return shift


class MujocoTerms:
    """Computes the terms of a compiled model in any state."""

    def __init__(
        self, model: Any, data: Any, forward: Forward | None = None, named: Any = None
    ) -> None:
        """The terms are computed by MuJoCo, or by the function `forward` that fills in an mjData.
        Bodies are named as in `named`, another model with the same bodies, if it is given."""
        self.model, self.data = model, data
        self.bodies = [(named or model).body(body).name for body in range(model.nbody)]
        self.forward = forward or mujoco.mj_forward
        self.at_rest = forward or mujoco.mj_fwdVelocity

    def __call__(self, state: Array, control: Array) -> Terms:
        """The `Terms` in a state under a control, and "acting": the kinds of constraints other than
        contacts that exert a force."""
        model = self.model
        data = self.data
        put(data, state)
        data.ctrl[:] = control
        self.forward(model, data)
        inertia = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, inertia)
        explicit = model.opt.disableflags & EXPLICIT
        within_margin = [
            (tuple(self.bodies[model.geom_bodyid[geom]] for geom in contact.geom), contact)
            for contact in data.contact
            if contact.dist <= contact.includemargin
            and contact.exclude == 0
            and contact.geom.min() >= 0
        ]
        axes = [(pair, contact.frame[3:6].copy()) for pair, contact in within_margin]
        terms = {
            "mass matrix": inertia,
            "passive": data.qfrc_passive.copy(),
            "actuator": data.qfrc_actuator.copy(),
            "damping": 0.0 * model.dof_damping if explicit else model.dof_damping,
            "contacts": [pair for pair, contact in within_margin if contact.dist <= 0.0],
            "axes": [] if model.opt.cone else axes,
            "acting": [
                name
                for name, kinds in ACTING
                if data.efc_force[np.isin(data.efc_type, kinds)].any()
            ],
        }
        bias = data.qfrc_bias.copy()
        data.qvel[:] = 0.0  # at rest the bias is gravity alone
        self.at_rest(model, data)
        return {**terms, "gravity": -data.qfrc_bias, "bias": bias - data.qfrc_bias}


class Port(Protocol):
    """A compiled model in a port of MuJoCo."""

    def load(self, data: Any) -> None:
        """Copies the state, the controls and the applied forces of an mjData."""

    def forward(self) -> None:
        """Computes all terms of the equations of motion."""

    def steps(self, count: int) -> None:
        """Takes `count` steps."""

    def unload(self, data: Any) -> None:
        """Writes the state and all terms into an mjData."""


class PortedModel:
    """A model file in a port of MuJoCo: a `PeerModel`, whose coordinates are MuJoCo's."""

    def __init__(
        self,
        make: Callable[[Any], Port],
        path: Path,
        layout: Layout,
        step: float,
        read: Any = None,
    ) -> None:
        """`make` builds the port of a compiled model. `read` is the same file compiled by another
        reader; if it is given, it is stepped in place of MuJoCo's model."""
        mujoco_model = mujoco.MjModel.from_xml_path(str(path))
        self.model = mujoco_model if read is None else read
        self.model.opt.timestep = step
        self.data = mujoco.MjData(self.model)
        self.port = make(self.model)
        data = mujoco.MjData(self.model)
        self.terms = MujocoTerms(self.model, data, self._forward, mujoco_model)

    @property
    def integrator(self) -> str:
        """The name of the model's integrator."""
        return integrator_of(self.model)

    def _forward(self, model: Any, data: Any) -> None:
        """Computes all terms by the port, and writes them into an mjData."""
        self.port.load(data)
        self.port.forward()
        self.port.unload(data)

    def begin(self, state: Array) -> None:
        """Puts the model into a state."""
        mujoco.mj_resetData(self.model, self.data)
        put(self.data, state)

    def advance(self, control: Array, force: Array, steps: int) -> Array:
        """Takes steps under a control and a generalised force; returns the state at the end."""
        data = self.data
        data.ctrl[:], data.qfrc_applied[:] = control, force
        self.port.load(data)
        self.port.steps(steps)
        self.port.unload(data)
        return state_of(data)
