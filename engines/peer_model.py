"""A user's model file as another engine reads it, for an audit: the terms of its equations of
motion and its steps in MuJoCo's coordinates, translated from the engine's coordinates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from plumbob.analytic.reference import Array

Terms = Mapping[str, Any]
"""Terms of the equations of motion in a state, in generalised coordinates:

- "mass matrix" [kg, kg m, kg m^2], shape (nv, nv);
- the forces "gravity", "passive" and "actuator", and "bias", which stands on the other side of the
  equation [N or N m], shape (nv,) each;
- "contacts": pairs of names of bodies that touch;
- "damping", if the engine's step is implicit in it: what the step adds to the diagonal of the mass
  matrix, per time step;
- "causes", if the engine knows them: {term: why it differs};
- "axes", if the engine's friction cone is a pyramid: the first axis of friction of each pair within
  its margin.
"""
# numbers of velocities of a free joint and of a ball joint
FREE_VELOCITIES, BALL_VELOCITIES = 6, 3


@dataclass(frozen=True)
class ModelJoint:
    """A joint of MuJoCo's model, and the numbers at which its coordinates begin."""

    name: str
    size: int  # degrees of freedom: 1, or FREE_VELOCITIES, or BALL_VELOCITIES
    position: int  # number of its first coordinate in qpos
    velocity: int  # number of its first velocity in qvel
    reference: Array  # coordinates at which the file draws it


@dataclass(frozen=True)
class Layout:
    """The names of a model's joints and actuators, in MuJoCo's order."""

    joints: tuple[ModelJoint, ...]
    actuators: tuple[str, ...]
    bodies: tuple[str, ...]  # bodies that can move

    @property
    def velocity(self) -> slice:
        """The slice of a state that holds its velocities."""
        first = sum(len(joint.reference) for joint in self.joints)
        return slice(first, first + sum(joint.size for joint in self.joints))


class PeerModel(Protocol):
    """A model file in an engine. States are MuJoCo's: qpos, qvel, and act if the engine has it."""

    @property
    def integrator(self) -> str:
        """MuJoCo's name for the engine's integrator."""

    def terms(self, state: Array, control: Array) -> Terms:
        """The terms of the equations of motion in a state under a control."""

    def begin(self, state: Array) -> None:
        """Puts the model into a state."""

    def advance(self, control: Array, force: Array, steps: int) -> Array:
        """Takes steps under a control and an additional generalised force; returns the state at the
        end."""


class MechanismDiffers(Exception):
    """Raised if an engine makes a different mechanism of a file; the text is the reason."""


class RefusedFile(MechanismDiffers):
    """Raised if an engine refuses a file; the text is the engine's error in one line."""


def rotation(attitude: Array) -> Array:
    """The rotation matrix of a quaternion [w, x, y, z], shape (3, 3)."""
    # Imported here: this module is loaded at each start of plumbob, scipy takes long to load.
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(attitude, scalar_first=True).as_matrix()


@dataclass(frozen=True)
class FreeJointFrame:
    """An engine's coordinates of a free joint. MuJoCo's velocity is the linear velocity in the
    world, then the angular velocity in the body."""

    # position and attitude [w, x, y, z] -> the engine's pose
    pose: Callable[[Array, Array], Array]
    place: Callable[[Array], tuple[Array, Array]]  # the engine's pose -> position and attitude
    size: int = 7  # number of coordinates of the engine's pose
    linear_first: bool = False  # whether the linear velocity stands before the angular velocity
    linear_in_body: bool = False  # whether the linear velocity is in the body's axes
    angular_in_body: bool = False  # whether the angular velocity is in the body's axes
    arm: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Vector from the body's frame to the point whose linear velocity the engine uses, in the
    body's axes [m]."""

    def jacobian(self, attitude: Array) -> Array:
        """The matrix T with which the engine's velocity is T times MuJoCo's, shape (6, 6)."""
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
        """The rate of the matrix T of `jacobian`, times MuJoCo's velocity, shape (6,). If it is not
        zero, the engine's linear velocity stands first."""
        out = np.zeros(FREE_VELOCITIES)
        spin = v[3:]
        if self.linear_in_body:
            out[:3] = -np.cross(spin, v[:3])
        elif any(self.arm):
            out[:3] = np.cross(spin, np.cross(spin, rotation(attitude) @ self.arm))
        return out


class EngineModel(Protocol):
    """A model file in an engine, in the engine's coordinates."""

    def put(self, q: Array, v: Array) -> None:
        """Puts the model into a state of coordinates and velocities."""

    def terms(self, q: Array, v: Array, control: Array) -> dict[str, Any]:
        """The `Terms` in a state under a control, in the engine's coordinates."""

    def advance(self, control: Array, force: Array, steps: int) -> tuple[Array, Array]:
        """Takes steps under a control and an additional generalised force; returns the coordinates
        and velocities at the end."""


class Translated:
    """A `PeerModel` of an `EngineModel`: translates coordinates of hinges and slides by the names
    of joints, and coordinates of free joints by a `FreeJointFrame`."""

    integrator = "euler"  # semi-implicit

    def __init__(
        self,
        engine: EngineModel,
        layout: Layout,
        hinges: Sequence[tuple[str, tuple[int, int]]],
        free: Sequence[tuple[int, int, FreeJointFrame]] = (),
        displaced: bool = False,
    ) -> None:
        """`hinges` are the hinges and slides in the order of the file: the name of each joint, and
        the numbers of its coordinate and velocity in the engine. `free` are the free joints: the
        numbers at which their coordinates and velocities begin in the engine, and their frames. If
        `displaced`, the engine's coordinates are zero as the file draws the model, where MuJoCo's
        are the joint's `ref`. Raises NotRead."""
        self.engine = engine
        joints = layout.joints
        self.velocity = layout.velocity
        if any(joint.size == BALL_VELOCITIES for joint in joints):
            raise MechanismDiffers("ball joints are not compared")
        counts = len(hinges) + FREE_VELOCITIES * len(free), sum(joint.size for joint in joints)
        scalar = [joint for joint in joints if joint.size == 1]
        if counts[0] != counts[1] or len(scalar) != len(hinges):
            raise MechanismDiffers(f"it has {counts[0]} of {counts[1]} degrees of freedom")
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
        floating = (joint for joint in joints if joint.size == FREE_VELOCITIES)
        self.free = [(joint, *at) for joint, at in zip(floating, free, strict=True)]
        self._jacobian = np.eye(counts[1])

    def begin(self, state: Array) -> None:
        """Puts the model into a state of MuJoCo."""
        self.engine.put(*self._own(state))

    def terms(self, state: Array, control: Array) -> Terms:
        """The terms in MuJoCo's coordinates. The engine's velocity is T v, where v is MuJoCo's, and
        T turns with the body: the mass matrix is T' M_e T, and the bias gains M_e dT/dt v."""
        q, v = self._own(state)
        terms = self.engine.terms(q, v, control)
        turning = np.zeros(len(v))
        for joint, _, at, frame in self.free:
            at_v = slice(at, at + FREE_VELOCITIES)
            turning[at_v] = frame.turning(_attitude(joint, state), v[at_v])
        terms["bias"] = terms["bias"] + terms["mass matrix"] @ turning
        terms["mass matrix"] = self._jacobian.T @ terms["mass matrix"] @ self._jacobian
        forces = ("gravity", "bias", "passive", "actuator")
        return {**terms, **{name: self._jacobian.T @ terms[name] for name in forces}}

    def advance(self, control: Array, force: Array, steps: int) -> Array:
        """Takes steps under a control and a force in MuJoCo's coordinates; returns the state at the
        end."""
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
        """The engine's coordinates and velocities of a state of MuJoCo."""
        ours, _, theirs, _ = self.hinges
        q = np.empty(len(ours) + sum(frame.size for *_, frame in self.free))
        q[theirs] = state[ours] - self.drawn
        for joint, at, _, frame in self.free:
            place = state[joint.position : joint.position + 3]
            q[at : at + frame.size] = frame.pose(place, _attitude(joint, state))
        self._jacobian = self._by_velocity(state)
        return q, self._jacobian @ state[self.velocity]

    def _by_velocity(self, qpos: Array) -> Array:
        """The matrix T with which the engine's velocity is T times MuJoCo's, shape (nv, nv)."""
        out = np.zeros_like(self._jacobian)
        out[self.hinges[3], self.hinges[1]] = 1.0
        for joint, _, at, frame in self.free:
            rows = slice(at, at + FREE_VELOCITIES)
            columns = slice(joint.velocity, joint.velocity + FREE_VELOCITIES)
            out[rows, columns] = frame.jacobian(_attitude(joint, qpos))
        return out


def _attitude(joint: ModelJoint, qpos: Array) -> Array:
    """The normalised quaternion of a free joint [w, x, y, z]."""
    attitude = qpos[joint.position + 3 : joint.position + 7]
    return np.asarray(attitude / np.linalg.norm(attitude))


def commands(layout: Layout, names: Sequence[str]) -> list[int]:
    """The number of MuJoCo's control of each of an engine's actuators. Actuators are matched by
    name or, if a name is unknown, by their order; the list is empty if their numbers differ."""
    if set(names) <= set(layout.actuators):
        return [layout.actuators.index(name) for name in names]
    return list(range(len(names))) if len(names) == len(layout.actuators) else []
