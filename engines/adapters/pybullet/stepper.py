"""A mechanism as PyBullet steps it.

Bullet's step of a multibody is semi-implicit Euler. It computes the accelerations at the start of
the step, then the impulses of motors, loops and contacts, then the positions with the new
velocities. A rotation is updated by the exponential of the new angular velocity.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.pybullet.builder import BASE, UNLIMITED, At, Built, build
from plumbob.engines.adapters.pybullet.client import TOUCHES, new_client
from plumbob.engines.joint_forces import (
    JointForce,
    actuators_of,
    idle_controls,
    passive_and_actuator_force,
)
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Options
from plumbob.engines.stepper import State

TURNING = ("ball", "free")  # kinds of joint whose coordinates include a quaternion


@dataclass(frozen=True)
class Loaded:
    """A hinge or a slide on which a spring, a damper or actuators act. The force is computed at the
    start of a step."""

    at: At  # link that the joint moves
    exerted: JointForce  # force of the spring, the damper and the actuators
    drawn: float  # coordinate in the drawing [rad] or [m]: Bullet's coordinate is 0 there
    alone: bool  # whether a force may act while all controls are 0


class BulletStepper:
    """A mechanism in a PyBullet world with these settings, which takes steps of `step` [s] from any
    state."""

    def __init__(self, mechanism: Mechanism, settings: Options, step: float) -> None:
        self.step = step
        self.mechanism = mechanism
        self._settings = settings
        self._touches = settings.get("contactBreakingThreshold", TOUCHES)
        self._client = new_client()
        self._attitudes = dict[int, Array]()
        self._begun, self._taken = 0.0, 0
        self._renew()
        self._idle = idle_controls(mechanism)
        self._loaded = tuple(_loaded(mechanism, self.built))
        self._driven = [
            (*at, joint.velocity) for joint, at in self._joints if joint.velocity is not None
        ]
        self._carried = [
            ((home.tree, home.link), body.mass * mechanism.gravity)
            for body, home in zip(mechanism.bodies, self.built.bodies, strict=True)
            if body.carried
        ]
        self._damped = [
            (at, joint.damping)
            for joint, at in self._joints
            if joint.kind == "ball" and np.any(joint.damping)
        ]

    def _renew(self) -> None:
        """Builds the mechanism in an empty world. A new world is needed because contacts outlive a
        change of the state."""
        self._client.resetSimulation()
        self.built = build(self._client, self.mechanism, self._settings, self.step)
        self._joints = tuple(zip(self.mechanism.joints, self.built.joints, strict=True))
        self._fresh = True

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]."""
        self._begun, self._taken = time, 0
        if not self._fresh:
            self._renew()
        first = degree = 0
        for number, (joint, at) in enumerate(self._joints):
            q = state.qpos[first : first + len(joint.reference)]
            v = state.qvel[degree : degree + len(joint.damping)]
            first, degree = first + len(q), degree + len(v)
            if joint.kind in TURNING:
                self._attitudes[number] = q[-4:].copy()
            if joint.kind == "free":
                self._put_free(at, q, v)
            elif joint.kind == "ball":
                self._put_ball(at, q, v)
            else:
                place = float(q[0] - joint.reference[0])
                self._client.resetJointState(*at, place, float(v[0]))

    def _put_free(self, at: At, q: Array, v: Array) -> None:
        """Sets the coordinates and the rates of a free body. Bullet has the place and the velocity
        of its centre of mass."""
        centre, axes = self.built.inertial[at]
        turn = Rotation.from_quat(q[3:], scalar_first=True)
        arm, spin = turn.apply(centre), turn.apply(v[3:])
        attitude = (turn * Rotation.from_quat(axes)).as_quat()
        self._client.resetBasePositionAndOrientation(at[0], q[:3] + arm, attitude)
        self._client.resetBaseVelocity(at[0], v[:3] + np.cross(spin, arm), spin)

    def _put_ball(self, at: At, q: Array, v: Array) -> None:
        """Sets the coordinates and the rates of a ball joint. Bullet has them along the principal
        axes of the link's inertia."""
        axes = Rotation.from_quat(self.built.inertial[at][1])
        turn = axes.inv() * Rotation.from_quat(q, scalar_first=True) * axes
        self._client.resetJointStateMultiDof(
            *at, turn.as_quat().tolist(), axes.inv().apply(v).tolist()
        )

    def state(self) -> State:
        """The present state. The sign of a quaternion is the sign that is nearer to the quaternion
        that was put or read last."""
        places, rates = list[Array](), list[Array]()
        for number, (joint, at) in enumerate(self._joints):
            if joint.kind in TURNING:
                place, attitude, rate = (self._free if joint.kind == "free" else self._ball)(at)
                if attitude @ self._attitudes[number] < 0.0:
                    attitude = -attitude
                self._attitudes[number] = attitude
                places += [place, attitude]
                rates.append(rate)
            else:
                q, v = self._client.getJointState(*at)[:2]
                places.append(q + joint.reference)
                rates.append(np.array([v]))
        return State(np.concatenate(places), np.concatenate(rates))

    def _free(self, at: At) -> tuple[Array, Array, Array]:
        """The place [m], the attitude, scalar first, and the rates of a free body."""
        centre, axes = self.built.inertial[at]
        place, attitude = self._client.getBasePositionAndOrientation(at[0])
        moving, spin = map(np.array, self._client.getBaseVelocity(at[0]))
        turn = Rotation.from_quat(attitude) * Rotation.from_quat(axes).inv()
        arm = turn.apply(centre)
        rates = np.concatenate([moving - np.cross(spin, arm), turn.inv().apply(spin)])
        return np.array(place) - arm, turn.as_quat(scalar_first=True), rates

    def _ball(self, at: At) -> tuple[Array, Array, Array]:
        """An empty place, the attitude, scalar first, and the angular velocity of a ball joint."""
        axes = Rotation.from_quat(self.built.inertial[at][1])
        q, v = self._client.getJointStateMultiDof(*at)[:2]
        turn = axes * Rotation.from_quat(q) * axes.inv()
        return np.zeros(0), turn.as_quat(scalar_first=True), axes.apply(v)

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls), or with controls that are
        zero."""
        numbers = np.arange(self._taken + 1, self._taken + steps + 1, dtype=np.float64)
        times = self._begun + self.step * numbers
        moves = np.array([velocity(times) for *_, velocity in self._driven])
        ends = moves.reshape(len(moves), steps).T.tolist()  # velocities at the ends of steps
        rows = [self._idle] * steps if controls is None else controls.tolist()
        loaded = [x for x in self._loaded if controls is not None or x.alone]
        if self.mechanism.touching:  # another world may have changed the threshold
            self._client.setPhysicsEngineParameter(contactBreakingThreshold=self._touches)
        move = self._client.stepSimulation
        for row, velocities in zip(rows, ends, strict=True):
            self._drive(velocities)
            for part in loaded:
                self._load(part, row)
            self._damp()
            self._carry()
            move()
        self._taken += steps
        self._fresh = self._fresh and not steps

    def _drive(self, velocities: Sequence[float]) -> None:
        """Prescribes the velocities of joints at the end of the next step."""
        motor, kind = self._client.setJointMotorControl2, self._client.VELOCITY_CONTROL
        for (tree, link, _), velocity in zip(self._driven, velocities, strict=True):
            motor(tree, link, kind, targetVelocity=velocity, force=UNLIMITED)

    def _load(self, part: Loaded, controls: Sequence[float]) -> None:
        """Applies the force of a joint in the next step."""
        q, v = self._client.getJointState(*part.at)[:2]
        force = part.exerted(q + part.drawn, v, controls)
        self._client.setJointMotorControl2(*part.at, self._client.TORQUE_CONTROL, force=force)

    def _damp(self) -> None:
        """Applies the torques of the dampers of ball joints in the next step."""
        client = self._client
        for at, damping in self._damped:
            axes = Rotation.from_quat(self.built.inertial[at][1])
            torque = axes.inv().apply(-damping * self._ball(at)[2]).tolist()
            client.setJointMotorControlMultiDof(*at, client.TORQUE_CONTROL, force=torque)

    def _carry(self) -> None:
        """Applies the forces that carry the weights of bodies in the next step."""
        client = self._client
        for at, weight in self._carried:
            if at[1] == BASE:
                centre = client.getBasePositionAndOrientation(at[0])[0]
            else:
                centre = client.getLinkState(*at, computeForwardKinematics=1)[0]
            client.applyExternalForce(*at, (-weight).tolist(), centre, client.WORLD_FRAME)


def _loaded(mechanism: Mechanism, built: Built) -> Iterator[Loaded]:
    """The hinges and slides that have a spring, a damper or actuators."""
    for number, (joint, at) in enumerate(zip(mechanism.joints, built.joints, strict=True)):
        actuators = actuators_of(mechanism, number)
        alone = bool(joint.stiffness or joint.damping[0]) or any(any(a.bias) for a in actuators)
        if joint.kind not in TURNING and (alone or actuators):
            exerted = passive_and_actuator_force(joint, actuators)
            yield Loaded(at, exerted, float(joint.reference[0]), alone)
