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
from plumbob.engines.joint_forces import (
    JointForce,
    actuator_force,
    actuators_of,
    idle_controls,
)
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.peer_model import rotation
from plumbob.engines.stepper import Forces, State
from plumbob.engines.tangent_space import exponential, logarithm

TURNING = ("ball", "free")  # kinds of joint whose coordinates include a quaternion


@dataclass(frozen=True)
class Motor:
    """The actuators and the armature of a joint with one degree of freedom."""

    joint: Any  # DART's joint
    exerted: JointForce  # force of the actuators
    drawn: float  # coordinate in the drawing [rad] or [m]: DART's coordinate is 0 there
    rotor: float  # armature divided by the step [N m s/rad] or [N s/m]
    alone: bool  # whether a force may act while all controls are 0

    def force(self, controls: Sequence[float]) -> float:
        """The force at the start of a step [N m] or [N]. DART has no armature. Two terms together
        act as one: a damper of armature/step, which is implicit in DART's step, and the opposite
        force of that damper at the velocity before the step, which is added here."""
        place: float = 0.0
        rate: float = 0.0
        if self.alone:
            place = self.joint.getPosition(0) + self.drawn
            rate = self.joint.getVelocity(0)
        return self.exerted(place, rate, controls) + self.rotor * rate


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
        self.built = build(mechanism, step)
        self._pairs = len(mechanism.touching)
        self._joints = tuple(zip(mechanism.joints, self.built.joints, strict=True))
        self.motors = tuple(_motors(mechanism, self.built, step))
        self._driven = [
            (made, joint.velocity) for joint, made in self._joints if joint.velocity is not None
        ]
        self._idle = idle_controls(mechanism)
        self._attitudes = dict[int, Array]()
        self._begun, self._taken = 0.0, 0
        self._before = list[Array]()  # positions of the skeletons before the last step
        self._solver = solver
        # DART's constraints keep the distances that they find when they are added.
        self.put(start)
        close_loops(mechanism, self.built)

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]."""
        self._begun, self._taken = time, 0
        self.built.world.reset()
        if self._solver is not None:  # a solver starts from the impulses of its last step
            solver = self._solver()
            self.built.world.getConstraintSolver().setBoxedLcpSolver(solver)
        first = degree = 0
        for number, (joint, made) in enumerate(self._joints):
            q = state.qpos[first : first + len(joint.reference)]
            v = state.qvel[degree : degree + len(joint.damping)]
            first, degree = first + len(q), degree + len(v)
            if joint.kind in TURNING:
                self._attitudes[number] = q[-4:].copy()
                turned = logarithm(q[-4:])
                if joint.kind == "free":
                    # DART has the angular velocity first, along the world's axes.
                    v = np.concatenate([rotation(q[-4:]) @ v[3:], v[:3]])
                made.setPositions(np.concatenate([turned, q[:-4]]))
            else:
                made.setPositions(q - joint.reference)
            made.setVelocities(v)

    def state(self) -> State:
        """The present state. The sign of a quaternion is the sign that is nearer to the quaternion
        that was put or read last."""
        places, rates = list[Array](), list[Array]()
        for number, (joint, made) in enumerate(self._joints):
            q, v = made.getPositions(), made.getVelocities()
            if joint.kind in TURNING:
                attitude = exponential(q[:3])
                if attitude @ self._attitudes[number] < 0.0:
                    attitude = -attitude
                self._attitudes[number] = attitude
                places += [q[3:], attitude]
                rates.append(v[3:])
                turn = rotation(attitude).T @ v[:3] if joint.kind == "free" else v[:3]
                rates.append(turn)
            else:
                places.append(q + joint.reference)
                rates.append(v)
        return State(np.concatenate(places), np.concatenate(rates))

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls), or with controls that are
        zero."""
        numbers = np.arange(self._taken, self._taken + steps + 1, dtype=np.float64)
        times = self._begun + self.step * numbers
        moved = [np.diff(velocity(times)) / self.step for _, velocity in self._driven]
        # With the mean acceleration of a step, the velocity is exact at the end of the step.
        moves = np.array(moved).reshape(len(moved), steps).T.tolist()
        drive = [made.setCommand for made, _ in self._driven]
        rows = [self._idle] * steps if controls is None else controls.tolist()
        motors = [x for x in self.motors if controls is not None or x.alone]
        move = self.built.world.step
        for number, (row, accelerations) in enumerate(zip(rows, moves, strict=True)):
            for command, acceleration in zip(drive, accelerations, strict=True):
                command(0, acceleration)
            for motor in motors:
                motor.joint.setCommand(0, motor.force(row))
            if number == steps - 1:
                self._before = [skeleton.getPositions() for skeleton in self.built.skeletons]
            move()
        self._taken += steps

    def forces(self) -> Forces:
        """The forces of the last step. DART's forces of joints lack the contributions of contacts,
        loops, limits and dry friction: if the mechanism has such parts, the forces of joints are
        nan."""
        joints = np.full((len(self._joints), 3), math.nan)
        touching = np.full((self._pairs, 3), math.nan)
        if not self._taken:
            return Forces(joints, touching)
        touching[:] = 0.0
        for contact in self.built.world.getLastCollisionResult().getContacts():
            shapes = (contact.collisionObject1, contact.collisionObject2)
            first, second = (x.getShapeFrame().asShapeNode().getName() for x in shapes)
            # DART's force acts on the first object.
            number, sign = self.built.touching[second, first]
            touching[number] += sign * contact.force.ravel()
        if self.built.smooth:
            joints[:] = self._reactions()
        return Forces(joints, touching)

    def _reactions(self) -> list[Array]:
        """The force of each joint on the body that it moves [N], along the world's axes. DART gives
        the force on the parent, along the axes that the node had at the start of the step."""
        made = self.built.joints
        forces = [joint.getWrenchToChildBodyNode().ravel()[3:] for joint in made]
        now = [skeleton.getPositions() for skeleton in self.built.skeletons]
        self._place(self._before)
        turns = [joint.getChildBodyNode().getWorldTransform().rotation() for joint in made]
        self._place(now)
        return [-turn @ force for turn, force in zip(turns, forces, strict=True)]

    def _place(self, positions: Sequence[Array]) -> None:
        """Sets the positions of the skeletons."""
        for skeleton, values in zip(self.built.skeletons, positions, strict=True):
            skeleton.setPositions(values)


def _motors(mechanism: Mechanism, built: Built, step: float) -> Iterator[Motor]:
    """The motor of each joint that has actuators or an armature. Adds the damper of the armature to
    DART's joint."""
    for number, (joint, made) in enumerate(zip(mechanism.joints, built.joints, strict=True)):
        actuators = actuators_of(mechanism, number)
        rotor = float(joint.armature[0]) / step
        if actuators or rotor:
            made.setDampingCoefficient(0, float(joint.damping[0]) + rotor)
            alone = bool(rotor) or any(any(actuator.bias) for actuator in actuators)
            drawn = float(joint.reference[0])
            yield Motor(made, actuator_force(joint, actuators), drawn, rotor, alone)
