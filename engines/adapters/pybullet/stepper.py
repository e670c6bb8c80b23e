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
from plumbob.engines.adapters.joints import TURNING, joint_places, with_latest_signs
from plumbob.engines.adapters.pybullet.builder import UNLIMITED, Built, LinkKey, build
from plumbob.engines.adapters.pybullet.client import BASE, CONTACT_DISTANCE, new_client
from plumbob.engines.adapters.step_clock import StepClock
from plumbob.engines.joint_forces import (
    JointForce,
    actuators_of,
    idle_controls,
    passive_and_actuator_force,
)
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Options
from plumbob.engines.stepper import State


@dataclass(frozen=True)
class LoadedJoint:
    """A hinge or a slide on which a spring, a damper or actuators act. The force is computed at the
    start of a step."""

    link: LinkKey  # link that the joint moves
    exerted: JointForce  # force of the spring, the damper and the actuators
    # Coordinate [rad] or [m] in the reference pose, in which Bullet's coordinate is 0
    reference: float
    acts_without_control: bool  # whether a force may act while all controls are 0


class BulletStepper:
    """A mechanism in a PyBullet world with these settings, which takes steps of `step` [s] from any
    state."""

    def __init__(self, mechanism: Mechanism, settings: Options, step: float) -> None:
        self.step = step
        self.mechanism = mechanism
        self._settings = settings
        self._contact_distance = settings.get("contactBreakingThreshold", CONTACT_DISTANCE)
        self._client = new_client()
        self._latest = State(np.zeros(0), np.zeros(0))  # state that was put or read last
        self._clock = StepClock(step)
        self._places = tuple(joint_places(mechanism.joints))
        self._renew()
        self._idle = idle_controls(mechanism)
        self._loaded = tuple(_loaded_joints(mechanism, self.built))
        self._prescribed = [
            (link, joint.velocity) for joint, link in self._joints if joint.velocity is not None
        ]
        self._carried = [
            ((body_link.tree, body_link.link), body.mass * mechanism.gravity)
            for body, body_link in zip(mechanism.bodies, self.built.bodies, strict=True)
            if body.carried
        ]
        self._damped = [
            (link, joint.damping)
            for joint, link in self._joints
            if joint.kind == "ball" and np.any(joint.damping)
        ]

    def _renew(self) -> None:
        """Builds the mechanism in an empty world. A new world is needed because contacts outlive a
        change of the state."""
        self._client.resetSimulation()
        self.built = build(self._client, self.mechanism, self._settings, self.step)
        self._joints = tuple(zip(self.mechanism.joints, self.built.joints, strict=True))
        self._fresh = True  # whether no step has been taken in this world

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]."""
        self._clock.restart(time)
        self._latest = state
        if not self._fresh:
            self._renew()
        for (joint, link), (place, place_of_rates) in zip(
            self._joints, self._places, strict=True
        ):
            position = state.qpos[place]
            rates = state.qvel[place_of_rates]
            if joint.kind == "free":
                self._put_free(link, position, rates)
            elif joint.kind == "ball":
                self._put_ball(link, position, rates)
            else:
                coordinate = float(position[0] - joint.reference[0])
                self._client.resetJointState(*link, coordinate, float(rates[0]))

    def _put_free(self, link: LinkKey, position: Array, rates: Array) -> None:
        """Sets the coordinates and the rates of a free body. Bullet has the place and the velocity
        of its centre of mass."""
        multibody, _ = link
        centre, axes = self.built.inertial[link]
        turn = Rotation.from_quat(position[3:], scalar_first=True)
        arm = turn.apply(centre)
        spin = turn.apply(rates[3:])
        attitude = (turn * Rotation.from_quat(axes)).as_quat()
        self._client.resetBasePositionAndOrientation(multibody, position[:3] + arm, attitude)
        self._client.resetBaseVelocity(multibody, rates[:3] + np.cross(spin, arm), spin)

    def _put_ball(self, link: LinkKey, attitude: Array, spin: Array) -> None:
        """Sets the coordinates and the rates of a ball joint. Bullet has them along the principal
        axes of the link's inertia."""
        axes = self._principal_axes(link)
        turn = axes.inv() * Rotation.from_quat(attitude, scalar_first=True) * axes
        spin_in_axes = axes.inv().apply(spin)
        self._client.resetJointStateMultiDof(
            *link, turn.as_quat().tolist(), spin_in_axes.tolist()
        )

    def _principal_axes(self, link: LinkKey) -> Rotation:
        """The rotation from the principal axes of a link's inertia to the link's frame."""
        _, axes = self.built.inertial[link]
        return Rotation.from_quat(axes)

    def state(self) -> State:
        """The present state. The sign of a quaternion is the sign that is nearer to the quaternion
        that was put or read last."""
        positions = list[Array]()
        velocities = list[Array]()
        for joint, link in self._joints:
            if joint.kind in TURNING:
                read = self._read_free if joint.kind == "free" else self._read_ball
                position, rates = read(link)
                positions.append(position)
                velocities.append(rates)
            else:
                coordinate, rate, *_ = self._client.getJointState(*link)
                positions.append(coordinate + joint.reference)
                velocities.append(np.array([rate]))
        unsigned = np.concatenate(positions)
        qpos = with_latest_signs(self.mechanism.joints, unsigned, self._latest.qpos)
        self._latest = State(qpos, np.concatenate(velocities))
        return self._latest

    def _read_free(self, link: LinkKey) -> tuple[Array, Array]:
        """The coordinates and the rates of a free body."""
        multibody, _ = link
        centre, axes = self.built.inertial[link]
        place, attitude = self._client.getBasePositionAndOrientation(multibody)
        velocity, spin = map(np.array, self._client.getBaseVelocity(multibody))
        turn = Rotation.from_quat(attitude) * Rotation.from_quat(axes).inv()
        arm = turn.apply(centre)
        position = np.concatenate([np.array(place) - arm, turn.as_quat(scalar_first=True)])
        rates = np.concatenate([velocity - np.cross(spin, arm), turn.inv().apply(spin)])
        return position, rates

    def _read_ball(self, link: LinkKey) -> tuple[Array, Array]:
        """The attitude, scalar first, and the angular velocity of a ball joint."""
        axes = self._principal_axes(link)
        attitude, spin, *_ = self._client.getJointStateMultiDof(*link)
        turn = axes * Rotation.from_quat(attitude) * axes.inv()
        return turn.as_quat(scalar_first=True), axes.apply(spin)

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls), or with controls that are
        zero."""
        velocities = self._prescribed_velocities(steps)
        rows = [self._idle] * steps if controls is None else controls.tolist()
        loaded = [
            joint
            for joint in self._loaded
            if controls is not None or joint.acts_without_control
        ]
        if self.mechanism.touching:  # another world may have changed the threshold
            self._client.setPhysicsEngineParameter(
                contactBreakingThreshold=self._contact_distance
            )
        take_step = self._client.stepSimulation
        for row, prescribed in zip(rows, velocities, strict=True):
            self._prescribe(prescribed)
            for joint in loaded:
                self._load(joint, row)
            self._damp()
            self._carry()
            take_step()
        self._clock.steps_taken += steps
        self._fresh = self._fresh and not steps

    def _prescribed_velocities(self, steps: int) -> list[list[float]]:
        """For each of the next steps, the velocities at its end of the joints whose motion is
        prescribed."""
        ends = self._clock.next_times(steps)[1:]
        columns = np.array([velocity(ends) for _, velocity in self._prescribed])
        rows: list[list[float]] = columns.reshape(len(columns), steps).T.tolist()
        return rows

    def _prescribe(self, velocities: Sequence[float]) -> None:
        """Prescribes the velocities of joints at the end of the next step."""
        motor = self._client.setJointMotorControl2
        kind = self._client.VELOCITY_CONTROL
        for (link, _), velocity in zip(self._prescribed, velocities, strict=True):
            motor(*link, kind, targetVelocity=velocity, force=UNLIMITED)

    def _load(self, joint: LoadedJoint, controls: Sequence[float]) -> None:
        """Applies the force of a joint in the next step."""
        client = self._client
        coordinate, rate, *_ = client.getJointState(*joint.link)
        force = joint.exerted(coordinate + joint.reference, rate, controls)
        client.setJointMotorControl2(*joint.link, client.TORQUE_CONTROL, force=force)

    def _damp(self) -> None:
        """Applies the torques of the dampers of ball joints in the next step."""
        client = self._client
        for link, damping in self._damped:
            _, spin = self._read_ball(link)
            torque = self._principal_axes(link).inv().apply(-damping * spin)
            client.setJointMotorControlMultiDof(
                *link, client.TORQUE_CONTROL, force=torque.tolist()
            )

    def _carry(self) -> None:
        """Applies the forces that carry the weights of bodies in the next step."""
        client = self._client
        for (multibody, number), weight in self._carried:
            if number == BASE:
                centre, _ = client.getBasePositionAndOrientation(multibody)
            else:
                centre, *_ = client.getLinkState(multibody, number, computeForwardKinematics=1)
            force = (-weight).tolist()
            client.applyExternalForce(multibody, number, force, centre, client.WORLD_FRAME)


def _loaded_joints(mechanism: Mechanism, built: Built) -> Iterator[LoadedJoint]:
    """The hinges and slides that have a spring, a damper or actuators."""
    for number, (joint, link) in enumerate(zip(mechanism.joints, built.joints, strict=True)):
        actuators = actuators_of(mechanism, number)
        passive = bool(joint.stiffness or joint.damping[0])
        biased = any(actuator.biased for actuator in actuators)
        if joint.kind not in TURNING and (passive or actuators):
            exerted = passive_and_actuator_force(joint, actuators)
            reference = float(joint.reference[0])
            yield LoadedJoint(link, exerted, reference, acts_without_control=passive or biased)
