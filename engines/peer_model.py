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
        turn = rotation(attitude)
        linear = slice(0, 3)
        angular = slice(3, 6)
        if not self.linear_first:
            linear, angular = angular, linear
        jacobian = np.zeros((6, 6))
        jacobian[linear, :3] = turn.T if self.linear_in_body else np.eye(3)
        jacobian[linear, 3:] = turn @ np.cross(self.arm, np.eye(3))
        jacobian[angular, 3:] = np.eye(3) if self.angular_in_body else turn
        return jacobian

    def turning(self, attitude: Array, v: Array) -> Array:
        """The rate of the matrix T of `jacobian`, times MuJoCo's velocity, shape (6,). `v` is the
        engine's velocity. If the result is not zero, the linear velocity stands first in it."""
        rate = np.zeros(FREE_VELOCITIES)
        spin = v[3:]
        if self.linear_in_body:
            rate[:3] = -np.cross(spin, v[:3])
        elif any(self.arm):
            rate[:3] = np.cross(spin, np.cross(spin, rotation(attitude) @ self.arm))
        return rate


class EngineModel(Protocol):
    """A model file in an engine, in the engine's coordinates."""

    def put(self, q: Array, v: Array) -> None:
        """Puts the model into a state of coordinates and velocities."""

    def terms(self, q: Array, v: Array, control: Array) -> dict[str, Any]:
        """The `Terms` in a state under a control, in the engine's coordinates."""

    def advance(self, control: Array, force: Array, steps: int) -> tuple[Array, Array]:
        """Takes steps under a control and an additional generalised force; returns the coordinates
        and velocities at the end."""


@dataclass(frozen=True)
class EngineJoint:
    """A hinge, a slide or a free joint in an engine, and the numbers at which its coordinates and
    its velocities begin there."""

    position: int
    velocity: int
    name: str = ""
    frame: FreeJointFrame | None = None  # coordinates of a free joint; None for other joints


@dataclass(frozen=True)
class FreeJoint:
    """A free joint in MuJoCo and in an engine."""

    joint: ModelJoint
    frame: FreeJointFrame
    positions: slice  # the engine's coordinates
    velocities: slice  # the engine's velocities

    def attitude(self, qpos: Array) -> Array:
        """The normalised quaternion [w, x, y, z] in a state of MuJoCo."""
        attitude = qpos[self.joint.position + 3 : self.joint.position + 7]
        return np.asarray(attitude / np.linalg.norm(attitude))


class Translated:
    """A `PeerModel` of an `EngineModel`: translates coordinates of hinges and slides by the names
    of joints, and coordinates of free joints by a `FreeJointFrame`."""

    integrator = "euler"  # semi-implicit

    def __init__(
        self,
        engine: EngineModel,
        layout: Layout,
        joints: Sequence[EngineJoint],
        displaced: bool = False,
    ) -> None:
        """`joints` are the engine's joints in the order of the file. If `displaced`, the engine's
        coordinates are zero as the file draws the model, where MuJoCo's are the joint's `ref`.
        Raises MechanismDiffers."""
        self.engine = engine
        self.velocity = layout.velocity
        if any(joint.size == BALL_VELOCITIES for joint in layout.joints):
            raise MechanismDiffers("ball joints are not compared")
        hinges = [joint for joint in joints if joint.frame is None]
        free = [joint for joint in joints if joint.frame is not None]
        degrees = sum(joint.size for joint in layout.joints)
        engine_degrees = len(hinges) + FREE_VELOCITIES * len(free)
        model_hinges = [joint for joint in layout.joints if joint.size == 1]
        if engine_degrees != degrees or len(model_hinges) != len(hinges):
            raise MechanismDiffers(f"it has {engine_degrees} of {degrees} degrees of freedom")
        matched = _matched_hinges(model_hinges, hinges)
        self._jacobian = np.eye(degrees)
        # Numbers of the coordinates and velocities of hinges, in MuJoCo and in the engine
        self._positions = np.array([joint.position for joint in model_hinges], int)
        self._velocities = np.array([joint.velocity for joint in model_hinges], int)
        self._engine_positions = np.array([hinge.position for hinge in matched], int)
        self._engine_velocities = np.array([hinge.velocity for hinge in matched], int)
        self._drawn = displaced * np.array([joint.reference[0] for joint in model_hinges])
        floating = [joint for joint in layout.joints if joint.size == FREE_VELOCITIES]
        self._free = list(map(_free_joint, floating, free))

    def begin(self, state: Array) -> None:
        """Puts the model into a state of MuJoCo."""
        self.engine.put(*self._in_engine(state))

    def terms(self, state: Array, control: Array) -> Terms:
        """The terms in MuJoCo's coordinates. The engine's velocity is T v, where v is MuJoCo's, and
        T turns with the body: the mass matrix is T' M_e T, and the bias gains M_e dT/dt v."""
        q, v = self._in_engine(state)
        terms = self.engine.terms(q, v, control)
        turning = np.zeros(len(v))
        for free in self._free:
            attitude = free.attitude(state)
            turning[free.velocities] = free.frame.turning(attitude, v[free.velocities])
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
        qpos[self._positions] = q[self._engine_positions] + self._drawn
        for free in self._free:
            first = free.joint.position
            qpos[first : first + 7] = np.concatenate(free.frame.place(q[free.positions]))
        self._jacobian = self._velocity_jacobian(qpos)
        return np.concatenate([qpos, np.linalg.solve(self._jacobian, v)])

    def _in_engine(self, state: Array) -> tuple[Array, Array]:
        """The engine's coordinates and velocities of a state of MuJoCo."""
        count = len(self._positions) + sum(free.frame.size for free in self._free)
        q = np.empty(count)
        q[self._engine_positions] = state[self._positions] - self._drawn
        for free in self._free:
            place = state[free.joint.position : free.joint.position + 3]
            q[free.positions] = free.frame.pose(place, free.attitude(state))
        self._jacobian = self._velocity_jacobian(state)
        return q, self._jacobian @ state[self.velocity]

    def _velocity_jacobian(self, qpos: Array) -> Array:
        """The matrix T with which the engine's velocity is T times MuJoCo's, shape (nv, nv)."""
        jacobian = np.zeros_like(self._jacobian)
        jacobian[self._engine_velocities, self._velocities] = 1.0
        for free in self._free:
            first = free.joint.velocity
            columns = slice(first, first + FREE_VELOCITIES)
            jacobian[free.velocities, columns] = free.frame.jacobian(free.attitude(qpos))
        return jacobian


def _matched_hinges(
    model_hinges: Sequence[ModelJoint], hinges: Sequence[EngineJoint]
) -> Sequence[EngineJoint]:
    """The engine's hinge for each of MuJoCo's: the hinge of its name or, if the names differ, the
    hinge at its place in the order of the file."""
    by_name = {hinge.name: hinge for hinge in hinges}
    names = [joint.name for joint in model_hinges]
    return [by_name[name] for name in names] if set(names) == set(by_name) else hinges


def _free_joint(joint: ModelJoint, engine_joint: EngineJoint) -> FreeJoint:
    """A free joint of MuJoCo, and the engine's joint for it."""
    frame = engine_joint.frame
    assert frame is not None
    first, first_rate = engine_joint.position, engine_joint.velocity
    positions = slice(first, first + frame.size)
    return FreeJoint(joint, frame, positions, slice(first_rate, first_rate + FREE_VELOCITIES))


def commands(layout: Layout, names: Sequence[str]) -> list[int]:
    """The number of MuJoCo's control for each of an engine's actuators. Actuators are matched by
    their names or, if a name is unknown, by their order. The list is empty if a name is unknown and
    the engine has another number of actuators."""
    if set(names) <= set(layout.actuators):
        return [layout.actuators.index(name) for name in names]
    return list(range(len(names))) if len(names) == len(layout.actuators) else []
