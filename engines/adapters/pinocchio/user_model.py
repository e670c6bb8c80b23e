"""A user's model file in Pinocchio: the numbers that Pinocchio reads from it, and runs of its
model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import Fields
from plumbob.engines.peer_model import (
    FREE_VELOCITIES,
    EngineJoint,
    FreeJointFrame,
    Layout,
    MechanismDiffers,
    PeerModel,
    RefusedFile,
    Translated,
)
from plumbob.models.border import border


def _read(path: Path) -> Any:
    """The model that Pinocchio makes of a file; raises RefusedFile."""
    with border(RefusedFile):
        return pinocchio.buildModelFromMJCF(str(path))


def model_fields(path: Path) -> Fields:
    """The numbers that Pinocchio reads from a model file; raises RefusedFile."""
    model = _read(path)
    yield "gravity", "", model.gravity.linear
    for frame in model.frames:
        inertia = model.inertias[frame.parentJoint]
        if frame.type == pinocchio.FrameType.BODY and frame.parentJoint:
            yield "mass", frame.name, inertia.mass
            yield "inertia", frame.name, np.linalg.eigvalsh(inertia.inertia)
    for number in range(1, model.njoints):
        if model.nvs[number] == 1:
            degree = model.idx_vs[number]
            name = model.names[number]
            yield "armature", name, model.armature[degree]
            yield "damping", name, model.damping[degree]
            yield "frictionloss", name, model.upperDryFrictionLimit[degree]


class PinocchioModel:
    """A user's model, stepped by semi-implicit Euler with implicit damping of joints. Pinocchio's
    forward dynamics ignores the damping that its model has: it is added here."""

    def __init__(self, model: Any, step: float) -> None:
        self.model = model
        self.data = model.createData()
        self.step = step
        self.damping = np.array(model.damping)
        self.implicit = model.copy()
        self.implicit.armature = model.armature + step * self.damping

    def put(self, q: Array, v: Array) -> None:
        """Sets the coordinates and their rates."""
        self.q, self.v = q, v

    def terms(self, q: Array, v: Array, control: Array) -> dict[str, Any]:
        """The terms of the equations of motion. The model has no springs, actuators or contacts."""
        # Pinocchio fills only the upper triangle of the mass matrix.
        upper = np.triu(pinocchio.crba(self.model, self.data, q))
        weight = np.array(pinocchio.computeGeneralizedGravity(self.model, self.data, q))
        return {
            "mass matrix": upper + np.triu(upper, 1).T,
            "gravity": -weight,
            "bias": pinocchio.nonLinearEffects(self.model, self.data, q, v) - weight,
            "passive": -self.damping * v,
            "actuator": np.zeros(len(v)),
            "damping": self.damping,
            "contacts": [],
        }

    def advance(self, control: Array, force: Array, steps: int) -> tuple[Array, Array]:
        """Takes `steps` steps under a generalised `force`, which is held; returns the coordinates
        and their rates. The model has no actuators: the control has no effect."""
        for _ in range(steps):
            damped_force = force - self.damping * self.v
            acceleration = pinocchio.aba(self.implicit, self.data, self.q, self.v, damped_force)
            self.v = self.v + self.step * acceleration
            self.q = pinocchio.integrate(self.model, self.q, self.step * self.v)
        return self.q, self.v


FRAME = FreeJointFrame(
    lambda place, attitude: np.concatenate([place, np.roll(attitude, -1)]),
    lambda pose: (pose[:3], np.roll(pose[3:], 1)),
    linear_first=True,
    linear_in_body=True,
    angular_in_body=True,
)


def user_model(path: Path, layout: Layout, step: float) -> PeerModel:
    """The model of a file in Pinocchio at `step` [s], with the places of its joints in Pinocchio's
    coordinates; raises NotRead. If a body has several joints, Pinocchio has one joint for them,
    whose coordinates are in the order of the joints."""
    model = _read(path)
    joints = list[EngineJoint]()
    for number in range(1, model.njoints):
        first = int(model.idx_qs[number])
        first_rate = int(model.idx_vs[number])
        name = model.names[number]
        coordinates = model.nqs[number]
        rates = model.nvs[number]
        if rates == FREE_VELOCITIES and coordinates > FREE_VELOCITIES:
            joints.append(EngineJoint(first, first_rate, frame=FRAME))
        elif rates != coordinates:
            raise MechanismDiffers(f"its joint {name} is of a kind that is not compared")
        else:
            # Each of several joints gets a different name: the name, the name with "+", ...
            joints += [
                EngineJoint(first + degree, first_rate + degree, name + "+" * degree)
                for degree in range(rates)
            ]
    return Translated(PinocchioModel(model, step), layout, joints)
