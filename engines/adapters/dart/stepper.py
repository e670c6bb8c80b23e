"""A mechanism as DART steps it.

DART's step is semi-implicit Euler, with implicit springs and dampers of joints. A rotation is a
rotation vector, updated by the exponential of the new angular velocity. If a step turns by less
than 1 mrad, DART's exponential is too large by a sixth of the cube of the angle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.dart.builder import Built, build, close_loops
from plumbob.engines.adapters.joints import TURNING, joint_places, with_latest_signs
from plumbob.engines.adapters.step_clock import StepClock
from plumbob.engines.joint_forces import (
    JointForce,
    actuator_force,
    actuators_of,
    idle_controls,
)
from plumbob.engines.mechanism import Joint, Mechanism
from plumbob.engines.peer_model import rotation
from plumbob.engines.stepper import State
from plumbob.engines.tangent_space import exponential, logarithm

# [rad/s] or [m/s]: a run with a larger rate has diverged. Up to this rate a mass or an inertia of
# 1e108 times the square of a rate is finite.
FASTEST = 1e100


@dataclass(frozen=True)
class Motor:
    """The actuators and the armature of a joint with one degree of freedom."""

    joint: Any  # DART's joint
    exerted: JointForce  # force of the actuators
    # Coordinate [rad] or [m] in the reference pose, in which DART's coordinate is 0
    reference: float
    rotor: float  # armature divided by the step [N m s/rad] or [N s/m]
    acts_without_control: bool  # whether a force may act while all controls are 0

    def force(self, controls: Sequence[float]) -> float:
        """The force at the start of a step [N m] or [N]. DART has no armature. Two terms together
        act as one: a damper of armature/step, which is implicit in DART's step, and the opposite
        force of that damper at the velocity before the step, which is added here."""
        coordinate = 0.0
        rate = 0.0
        if self.acts_without_control:
            coordinate = self.joint.getPosition(0) + self.reference
            rate = self.joint.getVelocity(0)
        return self.exerted(coordinate, rate, controls) + self.rotor * rate


class DartStepper:
    """A mechanism in a DART world, which takes steps of `step` [s] from any state. `solver` returns
    DART's object that solves for contacts; if `solver` is None, DART's default solver is used."""

    def __init__(
        self,
        mechanism: Mechanism,
        start: State,
        step: float,
        solver: Callable[[], Any] | None = None,
    ) -> None:
        self.step = step
        self.mechanism = mechanism
        self.built = build(mechanism, step)
        self._joints = tuple(zip(mechanism.joints, self.built.joints, strict=True))
        self.motors = tuple(_motors(mechanism, self.built, step))
        self._places = tuple(joint_places(mechanism.joints))
        self._prescribed = [
            (dart_joint, joint.velocity)
            for joint, dart_joint in self._joints
            if joint.velocity is not None
        ]
        self._idle = idle_controls(mechanism)
        self._latest = start  # state that was put or read last
        self._clock = StepClock(step)
        self._solver = solver
        # DART's constraints keep the distances that they find when they are added.
        self.put(start)
        close_loops(mechanism, self.built)

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]."""
        self._clock.restart(time)
        self._latest = state
        self.built.world.reset()
        if self._solver is not None:  # a solver starts from the impulses of its last step
            solver = self._solver()
            self.built.world.getConstraintSolver().setBoxedLcpSolver(solver)
        for (joint, dart_joint), (place, place_of_rates) in zip(
            self._joints, self._places, strict=True
        ):
            dart_position, rates = _to_dart(
                joint, state.qpos[place], state.qvel[place_of_rates]
            )
            dart_joint.setPositions(dart_position)
            dart_joint.setVelocities(rates)

    def state(self) -> State:
        """The present state. The sign of a quaternion is the sign that is nearer to the quaternion
        that was put or read last.

        DART leaves out forces and accelerations that are not finite, and continues. If a rate
        exceeds FASTEST, all numbers of the state are therefore nan."""
        positions = list[Array]()
        velocities = list[Array]()
        for joint, dart_joint in self._joints:
            position, rates = _from_dart(
                joint, dart_joint.getPositions(), dart_joint.getVelocities()
            )
            positions.append(position)
            velocities.append(rates)
        unsigned = np.concatenate(positions)
        qpos = with_latest_signs(self.mechanism.joints, unsigned, self._latest.qpos)
        qvel = np.concatenate(velocities)
        self._latest = State(qpos, qvel)
        diverged = np.abs(qvel).max() > FASTEST
        return State(math.nan * qpos, math.nan * qvel) if diverged else self._latest

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls), or with controls that are
        zero."""
        accelerations = self._prescribed_accelerations(steps)
        commands = [dart_joint.setCommand for dart_joint, _ in self._prescribed]
        rows = [self._idle] * steps if controls is None else controls.tolist()
        motors = [
            motor for motor in self.motors if controls is not None or motor.acts_without_control
        ]
        take_step = self.built.world.step
        for row, prescribed in zip(rows, accelerations, strict=True):
            for command, acceleration in zip(commands, prescribed, strict=True):
                command(0, acceleration)
            for motor in motors:
                motor.joint.setCommand(0, motor.force(row))
            take_step()
        self._clock.steps_taken += steps

    def _prescribed_accelerations(self, steps: int) -> list[list[float]]:
        """For each of the next steps, the accelerations of the joints whose motion is
        prescribed."""
        times = self._clock.next_times(steps)
        # With the mean acceleration of a step, the velocity is exact at the end of the step.
        columns = [np.diff(velocity(times)) / self.step for _, velocity in self._prescribed]
        rows: list[list[float]] = np.array(columns).reshape(len(columns), steps).T.tolist()
        return rows


def _to_dart(joint: Joint, position: Array, rates: Array) -> tuple[Array, Array]:
    """DART's coordinates and rates of a joint, from MuJoCo's. An attitude is a rotation vector,
    which comes before the place. DART has the angular velocity of a free body before the linear
    velocity, and along the world's axes."""
    if joint.kind not in TURNING:
        return position - joint.reference, rates
    attitude = position[-4:]
    if joint.kind == "free":
        rates = np.concatenate([rotation(attitude) @ rates[3:], rates[:3]])
    return np.concatenate([logarithm(attitude), position[:-4]]), rates


def _from_dart(joint: Joint, position: Array, rates: Array) -> tuple[Array, Array]:
    """MuJoCo's coordinates and rates of a joint, from DART's. A quaternion may have either sign."""
    if joint.kind not in TURNING:
        return position + joint.reference, rates
    attitude = exponential(position[:3])
    spin = rates[:3]
    if joint.kind == "free":
        spin = rotation(attitude).T @ spin
    return np.concatenate([position[3:], attitude]), np.concatenate([rates[3:], spin])


def _motors(mechanism: Mechanism, built: Built, step: float) -> Iterator[Motor]:
    """The motor of each joint that has actuators or an armature. Adds the damper of the armature to
    DART's joint."""
    joints = zip(mechanism.joints, built.joints, strict=True)
    for number, (joint, dart_joint) in enumerate(joints):
        actuators = actuators_of(mechanism, number)
        rotor = float(joint.armature[0]) / step
        if actuators or rotor:
            dart_joint.setDampingCoefficient(0, float(joint.damping[0]) + rotor)
            biased = any(actuator.biased for actuator in actuators)
            yield Motor(
                joint=dart_joint,
                exerted=actuator_force(joint, actuators),
                reference=float(joint.reference[0]),
                rotor=rotor,
                acts_without_control=bool(rotor) or biased,
            )
