"""A user's model file as another engine reads it: what an audit needs of it, in MuJoCo's
coordinates, and their translation into an engine's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from plumbob.analytic.reference import Array

Terms = Mapping[str, Any]
"""Of a state, in generalised coordinates: "mass matrix", and the forces "gravity", "bias" (which
the others act against), "passive" and "actuator" [N or N m]; "contacts", pairs of names of bodies
that touch; beside them, where an engine has it, "damping", what an implicit step adds to the
diagonal of the mass matrix, per step, "causes", why a term is what it is, and "axes", the first
axis of friction of pairs within their margin, where friction's cone is a pyramid on them."""
FREE, BALL = 6, 3  # velocities of these joints


@dataclass(frozen=True)
class Joint:
    """A joint of MuJoCo's model, and where its coordinates begin."""

    name: str
    size: int  # degrees of freedom: 1, or FREE, or BALL
    position: int
    velocity: int
    reference: Array  # its coordinates as the file draws it


@dataclass(frozen=True)
class Layout:
    """The names of a model's joints and actuators, in MuJoCo's order."""

    joints: tuple[Joint, ...]
    actuators: tuple[str, ...]
    bodies: tuple[str, ...]  # that move

    @property
    def velocity(self) -> slice:
        """Where velocities are in a state."""
        first = sum(len(joint.reference) for joint in self.joints)
        return slice(first, first + sum(joint.size for joint in self.joints))


class PeerModel(Protocol):
    """A model file in an engine, whose states are MuJoCo's: qpos, qvel, and act where it has it."""

    def terms(self, state: Array, control: Array) -> Terms:
        """The terms of its equations of motion."""

    def begin(self, state: Array) -> None:
        """Start from a state."""

    def advance(self, control: Array, force: Array | None, steps: int) -> Array:
        """Take steps under a control and a generalised force beside it; the state at their end."""


class NotRead(Exception):
    """A file of which an engine makes another mechanism; its text says why."""


def rotation(attitude: Array) -> Array:
    """The matrix of a quaternion [w, x, y, z], shape (3, 3)."""
    from scipy.spatial.transform import Rotation  # not above: this module is loaded at each start

    return Rotation.from_quat(attitude, scalar_first=True).as_matrix()


@dataclass(frozen=True)
class Frame:
    """How an engine has the coordinates of a free joint: a pose by the position and the attitude
    [w, x, y, z], and where its velocity differs from MuJoCo's (linear in the world, then angular in
    the body)."""

    pose: Callable[[Array, Array], Array]
    place: Callable[[Array], tuple[Array, Array]]
    size: int = 7  # of the pose
    linear_first: bool = False
    linear_in_body: bool = False
    angular_in_body: bool = False

    def jacobian(self, attitude: Array) -> Array:
        """The engine's velocity by MuJoCo's, shape (6, 6)."""
        turned = rotation(attitude)
        linear, angular = slice(0, 3), slice(3, 6)
        if not self.linear_first:
            linear, angular = angular, linear
        out = np.zeros((6, 6))
        out[linear, :3] = turned.T if self.linear_in_body else np.eye(3)
        out[angular, 3:] = np.eye(3) if self.angular_in_body else turned
        return out


class EngineModel(Protocol):
    """A model file in an engine, in the engine's own coordinates."""

    def put(self, q: Array, v: Array) -> None:
        """Start from these coordinates."""

    def terms(self, q: Array, v: Array, control: Array) -> dict[str, Any]:
        """As `Terms` has them."""

    def advance(self, control: Array, force: Array | None, steps: int) -> tuple[Array, Array]:
        """As `PeerModel` does; the coordinates at the end."""


class Translated:
    """A `PeerModel` of an `EngineModel`: its coordinates are those of hinges and slides, by the
    names of joints, and of free joints, by a frame."""

    def __init__(
        self,
        engine: EngineModel,
        layout: Layout,
        hinges: Mapping[str, tuple[int, int]],
        free: Sequence[tuple[int, int, Frame]] = (),
        displaced: bool = False,
    ) -> None:
        """With {name of a joint of one degree of freedom: where its coordinate and velocity are},
        in the order of the file, and where those of free joints begin; coordinates may be
        displacements from the file's drawing, where MuJoCo has the joint's `ref`. Raises
        NotRead."""
        self.engine = engine
        joints = layout.joints
        counts = len(hinges) + FREE * len(free), sum(joint.size for joint in joints)
        scalar = [joint for joint in joints if joint.size == 1]
        if counts[0] != counts[1] or len(scalar) != len(hinges):
            raise NotRead(f"it has {counts[0]} of {counts[1]} degrees of freedom")
        names = list(hinges)
        known = {joint.name for joint in scalar} == set(names)
        order = [joint.name for joint in scalar] if known else names
        self.hinges = [
            (joint, *hinges[name], float(joint.reference[0]) if displaced else 0.0)
            for joint, name in zip(scalar, order, strict=True)
        ]
        floating = [joint for joint in joints if joint.size == FREE]
        self.free = [(joint, *at) for joint, at in zip(floating, free, strict=True)]
        self.velocity = layout.velocity
        self._jacobian = np.eye(counts[1])

    def begin(self, state: Array) -> None:
        """Start from a state of MuJoCo's."""
        q, v, _ = self._own(state)
        self.engine.put(q, v)

    def terms(self, state: Array, control: Array) -> Terms:
        """In MuJoCo's coordinates, whose velocity v is that of the engine, T v, by a T that turns
        with the body: M = T' M_e T, and the bias has M_e dT/dt v more."""
        q, v, jacobian = self._own(state)
        terms = self.engine.terms(q, v, control)
        terms["bias"] = terms["bias"] + terms["mass matrix"] @ self._turning(v)
        terms["mass matrix"] = jacobian.T @ terms["mass matrix"] @ jacobian
        forces = ("gravity", "bias", "passive", "actuator")
        return {**terms, **{name: jacobian.T @ terms[name] for name in forces}}

    def advance(self, control: Array, force: Array | None, steps: int) -> Array:
        """The state after steps under a control and a force in MuJoCo's coordinates."""
        if force is not None:
            force = self._jacobian @ force
        q, v = self.engine.advance(control, force, steps)
        qpos = np.empty(self.velocity.start)
        for joint, at, _, drawn in self.hinges:
            qpos[joint.position] = q[at] + drawn
        for joint, at, _, frame in self.free:
            place = frame.place(q[at : at + frame.size])
            qpos[joint.position : joint.position + 7] = np.concatenate(place)
        self._jacobian = self._by_velocity(qpos)
        return np.concatenate([qpos, self._jacobian.T @ v])

    def _own(self, state: Array) -> tuple[Array, Array, Array]:
        """The engine's coordinates and velocities, and these by MuJoCo's."""
        qpos, qvel = state[: self.velocity.start], state[self.velocity]
        q = np.empty(len(self.hinges) + sum(frame.size for *_, frame in self.free))
        for joint, at, _, drawn in self.hinges:
            q[at] = qpos[joint.position] - drawn
        for joint, at, _, frame in self.free:
            place = qpos[joint.position : joint.position + 7]
            attitude = place[3:] / np.linalg.norm(place[3:])
            q[at : at + frame.size] = frame.pose(place[:3], attitude)
        self._jacobian = self._by_velocity(qpos)
        return q, self._jacobian @ qvel, self._jacobian

    def _by_velocity(self, qpos: Array) -> Array:
        """T, which is orthogonal."""
        out = np.zeros_like(self._jacobian)
        for joint, _, at, _ in self.hinges:
            out[at, joint.velocity] = 1.0
        for joint, _, at, frame in self.free:
            attitude = qpos[joint.position + 3 : joint.position + 7]
            rows, columns = slice(at, at + FREE), slice(joint.velocity, joint.velocity + FREE)
            out[rows, columns] = frame.jacobian(attitude)
        return out

    def _turning(self, v: Array) -> Array:
        """dT/dt times MuJoCo's velocity: - w x v of a linear velocity in the body's axes."""
        out = np.zeros(len(self._jacobian))
        for _, _, at, frame in self.free:
            if frame.linear_in_body:  # with the angular one after it
                out[at : at + 3] = -np.cross(v[at + 3 : at + FREE], v[at : at + 3])
        return out


def commands(layout: Layout, names: Sequence[str]) -> list[int]:
    """Which of MuJoCo's controls each of an engine's actuators has: by name, or in order where
    there are as many."""
    if set(names) <= set(layout.actuators):
        return [layout.actuators.index(name) for name in names]
    return list(range(len(names))) if len(names) == len(layout.actuators) else []
