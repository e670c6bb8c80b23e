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

    @property
    def integrator(self) -> str:
        """The integrator of its steps, by MuJoCo's name for it."""

    def terms(self, state: Array, control: Array) -> Terms:
        """The terms of its equations of motion."""

    def begin(self, state: Array) -> None:
        """Start from a state."""

    def advance(self, control: Array, force: Array, steps: int) -> Array:
        """Take steps under a control and a generalised force beside it; the state at their end."""


class NotRead(Exception):
    """A file of which an engine makes another mechanism; its text says why."""


class RefusedFile(NotRead):
    """A file that an engine refuses; its text is the engine's error in one line."""


def rotation(attitude: Array) -> Array:
    """The matrix of a quaternion [w, x, y, z], shape (3, 3)."""
    from scipy.spatial.transform import (
        Rotation,  # not above: this module is loaded at each start
    )

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
    arm: tuple[float, ...] = (0.0, 0.0, 0.0)
    """In the body [m], to the point whose velocity the engine has, in the world."""

    def jacobian(self, attitude: Array) -> Array:
        """The engine's velocity by MuJoCo's, shape (6, 6)."""
        turned = rotation(attitude)
        linear = slice(0, 3)
        angular = slice(3, 6)
        if not self.linear_first:
            linear, angular = angular, linear
        out = np.zeros((6, 6))
        out[linear, :3] = turned.T if self.linear_in_body else np.eye(3)
        out[linear, 3:] = turned @ np.cross(self.arm, np.eye(3))
        out[angular, 3:] = np.eye(3) if self.angular_in_body else turned
        return out

    def turning(self, attitude: Array, v: Array) -> Array:
        """The rate of that matrix times MuJoCo's velocity: of the engine's, linear before angular
        where it is not zero, shape (6,)."""
        out = np.zeros(FREE)
        spin = v[3:]
        if self.linear_in_body:
            out[:3] = -np.cross(spin, v[:3])
        elif any(self.arm):
            out[:3] = np.cross(spin, np.cross(spin, rotation(attitude) @ self.arm))
        return out


class EngineModel(Protocol):
    """A model file in an engine, in the engine's own coordinates."""

    def put(self, q: Array, v: Array) -> None:
        """Start from these coordinates."""

    def terms(self, q: Array, v: Array, control: Array) -> dict[str, Any]:
        """As `Terms` has them."""

    def advance(self, control: Array, force: Array, steps: int) -> tuple[Array, Array]:
        """As `PeerModel` does; the coordinates at the end."""


class Translated:
    """A `PeerModel` of an `EngineModel`: its coordinates are those of hinges and slides, by the
    names of joints, and of free joints, by a frame."""

    integrator = "euler"  # semi-implicit

    def __init__(
        self,
        engine: EngineModel,
        layout: Layout,
        hinges: Sequence[tuple[str, tuple[int, int]]],
        free: Sequence[tuple[int, int, Frame]] = (),
        displaced: bool = False,
    ) -> None:
        """`hinges` are the joints of one degree of freedom in the order of the file: the name of
        each and the numbers of its coordinate and velocity. `free` are the numbers at which the
        coordinates and velocities of free joints begin, and their frames. If `displaced`, the
        coordinates are displacements from the file's drawing, where MuJoCo has the joint's `ref`.
        Raises NotRead."""
        self.engine = engine
        joints = layout.joints
        self.velocity = layout.velocity
        if any(joint.size == BALL for joint in joints):
            raise NotRead("ball joints are not compared")
        counts = len(hinges) + FREE * len(free), sum(joint.size for joint in joints)
        scalar = [joint for joint in joints if joint.size == 1]
        if counts[0] != counts[1] or len(scalar) != len(hinges):
            raise NotRead(f"it has {counts[0]} of {counts[1]} degrees of freedom")
        places = dict(hinges)
        known = {joint.name for joint in scalar} == set(places)
        theirs = [
            places[joint.name] if known else at
            for joint, (_, at) in zip(scalar, hinges, strict=True)
        ]
        rows = [
            [joint.position, joint.velocity, *at]
            for joint, at in zip(scalar, theirs, strict=True)
        ]
        self.hinges = np.array(rows, dtype=int).reshape(-1, 4).T
        self.drawn = displaced * np.array([joint.reference[0] for joint in scalar])
        floating = (joint for joint in joints if joint.size == FREE)
        self.free = [(joint, *at) for joint, at in zip(floating, free, strict=True)]
        self._jacobian = np.eye(counts[1])

    def begin(self, state: Array) -> None:
        """Start from a state of MuJoCo's."""
        self.engine.put(*self._own(state))

    def terms(self, state: Array, control: Array) -> Terms:
        """In MuJoCo's coordinates, whose velocity v is that of the engine, T v, by a T that turns
        with the body: M = T' M_e T, and the bias has M_e dT/dt v more."""
        q, v = self._own(state)
        terms = self.engine.terms(q, v, control)
        turning = np.zeros(len(v))
        for joint, _, at, frame in self.free:
            at_v = slice(at, at + FREE)
            turning[at_v] = frame.turning(_attitude(joint, state), v[at_v])
        terms["bias"] = terms["bias"] + terms["mass matrix"] @ turning
        terms["mass matrix"] = self._jacobian.T @ terms["mass matrix"] @ self._jacobian
        forces = ("gravity", "bias", "passive", "actuator")
        return {**terms, **{name: self._jacobian.T @ terms[name] for name in forces}}

    def advance(self, control: Array, force: Array, steps: int) -> Array:
        """The state after steps under a control and a force in MuJoCo's coordinates."""
        force = np.asarray(np.linalg.solve(self._jacobian.T, force), np.float64)
        q, v = self.engine.advance(control, force, steps)
        qpos = np.empty(self.velocity.start)
        (ours, _, theirs, _) = self.hinges
        qpos[ours] = q[theirs] + self.drawn
        for joint, at, _, frame in self.free:
            place = frame.place(q[at : at + frame.size])
            qpos[joint.position : joint.position + 7] = np.concatenate(place)
        self._jacobian = self._by_velocity(qpos)
        return np.concatenate([qpos, np.linalg.solve(self._jacobian, v)])

    def _own(self, state: Array) -> tuple[Array, Array]:
        """The engine's coordinates and velocities."""
        ours, _, theirs, _ = self.hinges
        q = np.empty(len(ours) + sum(frame.size for *_, frame in self.free))
        q[theirs] = state[ours] - self.drawn
        for joint, at, _, frame in self.free:
            place = state[joint.position : joint.position + 3]
            q[at : at + frame.size] = frame.pose(place, _attitude(joint, state))
        self._jacobian = self._by_velocity(state)
        return q, self._jacobian @ state[self.velocity]

    def _by_velocity(self, qpos: Array) -> Array:
        """T."""
        out = np.zeros_like(self._jacobian)
        out[self.hinges[3], self.hinges[1]] = 1.0
        for joint, _, at, frame in self.free:
            rows = slice(at, at + FREE)
            columns = slice(joint.velocity, joint.velocity + FREE)
            out[rows, columns] = frame.jacobian(_attitude(joint, qpos))
        return out


def _attitude(joint: Joint, qpos: Array) -> Array:
    """Of a free joint, of length 1."""
    attitude = qpos[joint.position + 3 : joint.position + 7]
    return np.asarray(attitude / np.linalg.norm(attitude))


def commands(layout: Layout, names: Sequence[str]) -> list[int]:
    """Which of MuJoCo's controls each of an engine's actuators has: by name, or in order where
    there are as many."""
    if set(names) <= set(layout.actuators):
        return [layout.actuators.index(name) for name in names]
    return list(range(len(names))) if len(names) == len(layout.actuators) else []
