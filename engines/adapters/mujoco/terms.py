"""The terms of a MuJoCo model's equations of motion in any state, as MuJoCo and as ports of it have
them, and the steps of a port."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
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
    return str(mujoco.mjtIntegrator(model.opt.integrator).name)[len("mjINT_") :].lower()


def put(data: Any, state: Array) -> None:
    """Give an mjData a state: qpos, qvel, act."""
    nq = data.qpos.size
    nv = data.qvel.size
    data.qpos[:] = state[:nq]
    data.qvel[:] = state[nq : nq + nv]
    data.act[:] = state[nq + nv :]


def state_of(data: Any) -> Array:
    """The state of an mjData."""
    return np.concatenate([data.qpos, data.qvel, data.act])


def shifted(model: Any, state: Array, shift: Array) -> Array:
    """A state moved by positions, velocities and activations of the tangent space."""
    nv = model.nv
    moved = state.copy()
    mujoco.mj_integratePos(model, moved[: model.nq], shift[:nv], 1.0)
    moved[model.nq :] += shift[nv:]
    return moved


def apart(model: Any, state: Array, other: Array) -> Array:
    """The shift from another state to a `state`, shape (2 nv + na,)."""
    nq = model.nq
    nv = model.nv
    shift = np.concatenate([np.zeros(nv), state[nq:] - other[nq:]])
    mujoco.mj_differentiatePos(model, shift[:nv], 1.0, other[:nq], state[:nq])
    return shift


class MujocoTerms:
    """The terms of the compiled `model` in any state."""

    def __init__(
        self, model: Any, data: Any, forward: Forward | None = None, named: Any = None
    ) -> None:
        """Worked out by MuJoCo, or by the `forward` of another that fills in an mjData; bodies have
        the names of those of `named`, another model of the same bodies."""
        self.model, self.data = model, data
        self.bodies = [(named or model).body(i).name for i in range(model.nbody)]
        self.forward = forward or mujoco.mj_forward
        self.at_rest = forward or mujoco.mj_fwdVelocity

    def __call__(self, state: Array, control: Array) -> Terms:
        """As `Terms` has them; "damping" is what an implicit step adds to the diagonal of the mass
        matrix, per step, and "acting" the constraints other than contacts that exert a force."""
        model = self.model
        data = self.data
        put(data, state)
        data.ctrl[:] = control
        self.forward(model, data)
        inertia = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, inertia)
        explicit = model.opt.disableflags & EXPLICIT
        felt = [
            (tuple(self.bodies[model.geom_bodyid[g]] for g in contact.geom), contact)
            for contact in data.contact
            if contact.dist <= contact.includemargin
            and contact.exclude == 0
            and contact.geom.min() >= 0
        ]
        terms = {
            "mass matrix": inertia,
            "passive": data.qfrc_passive.copy(),
            "actuator": data.qfrc_actuator.copy(),
            "damping": 0.0 * model.dof_damping if explicit else model.dof_damping,
            "contacts": [pair for pair, contact in felt if contact.dist <= 0.0],
            "axes": [(pair, contact.frame[3:6].copy()) for pair, contact in felt]
            if not model.opt.cone
            else [],
            "acting": [
                name
                for name, kinds in ACTING
                if data.efc_force[np.isin(data.efc_type, kinds)].any()
            ],
        }
        bias = data.qfrc_bias.copy()
        data.qvel[:] = 0.0  # what is left of it is gravity alone
        self.at_rest(model, data)
        return {**terms, "gravity": -data.qfrc_bias, "bias": bias - data.qfrc_bias}


class Port(Protocol):
    """A compiled model in a port of MuJoCo."""

    def load(self, data: Any) -> None:
        """Take over the state, control and applied forces of an mjData."""

    def forward(self) -> None:
        """Work out all terms."""

    def steps(self, count: int) -> None:
        """Take steps."""

    def unload(self, data: Any) -> None:
        """Fill in an mjData."""


class PortedModel:
    """A model file in a port of MuJoCo, whose coordinates are MuJoCo's."""

    def __init__(
        self,
        make: Callable[[Any], Port],
        path: Path,
        layout: Layout,
        step: float,
        read: Any = None,
    ) -> None:
        """With the model that another reader has `read`, in place of MuJoCo's own."""
        file = mujoco.MjModel.from_xml_path(str(path))
        self.model = file if read is None else read
        self.model.opt.timestep = step
        self.data = mujoco.MjData(self.model)
        self.port = make(self.model)
        data = mujoco.MjData(self.model)
        self.terms = MujocoTerms(self.model, data, self._forward, file)

    @property
    def integrator(self) -> str:
        """The name of the model's integrator."""
        return integrator_of(self.model)

    def _forward(self, model: Any, data: Any) -> None:
        self.port.load(data)
        self.port.forward()
        self.port.unload(data)

    def begin(self, state: Array) -> None:
        """Start from a state."""
        mujoco.mj_resetData(self.model, self.data)
        put(self.data, state)

    def advance(self, control: Array, force: Array, steps: int) -> Array:
        """Take steps under a control and a force; the state at their end."""
        data = self.data
        data.ctrl[:], data.qfrc_applied[:] = control, force
        self.port.load(data)
        self.port.steps(steps)
        self.port.unload(data)
        return state_of(data)
