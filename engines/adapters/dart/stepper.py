"""A mechanism in DART, stepped from any state.

DART's step is semi-implicit Euler with springs and dampers of joints implicit. A rotation is a
rotation vector; its update is the exponential of the new angular velocity, which below 1 mrad a
step is 1/6 of the angle's cube too large.
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

TURNING = ("ball", "free")  # kinds of joint with an attitude, a quaternion
FASTEST = 1e150  # [rad/s] or [m/s]: squares of larger rates are not finite


@dataclass(frozen=True)
class Motor:
    """The actuators and the armature of a joint with one degree of freedom."""

    joint: Any  # DART's
    exerted: JointForce  # by the actuators
    drawn: float  # the coordinate in the drawing, where DART's is 0 [rad] or [m]
    rotor: float  # armature over the step [N m s/rad] or [N s/m]
    alone: bool  # whether a force may act where all controls are 0

    def force(self, controls: Sequence[float]) -> float:
        """The force as a step begins [N m] or [N]. DART has no armature: a damper of armature/step,
        implicit in DART's step, and the same damper's force at the velocity before the step are
        one."""
        place: float = 0.0
        rate: float = 0.0
        if self.alone:
            place = self.joint.getPosition(0) + self.drawn
            rate = self.joint.getVelocity(0)
        return self.exerted(place, rate, controls) + self.rotor * rate


class DartStepper:
    """A mechanism in a DART world; `solver` makes DART's object that solves for contacts, or is
    None for the default."""

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
        self.put(start)  # DART closes loops as they stand
        close_loops(mechanism, self.built)

    def put(self, state: State, time: float = 0.0) -> None:
        """Set the state, at a time [s]."""
        self._begun, self._taken = time, 0
        self.built.world.reset()
        if self._solver is not None:  # an old one begins with the impulses of its last step
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
                if joint.kind == "free":  # DART's rates are along the world's axes, turn first
                    v = np.concatenate([rotation(q[-4:]) @ v[3:], v[:3]])
                made.setPositions(np.concatenate([turned, q[:-4]]))
            else:
                made.setPositions(q - joint.reference)
            made.setVelocities(v)

    def state(self) -> State:
        """The state now; a quaternion has the sign that is nearer to the last one.

        DART sets accelerations that are not finite to zero, and goes on: if a rate has become so
        large that its square is not finite, all numbers of the state are nan."""
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
        qpos, qvel = np.concatenate(places), np.concatenate(rates)
        lost = np.abs(qvel).max() > FASTEST
        return State(math.nan * qpos, math.nan * qvel) if lost else State(qpos, qvel)

    def advance(self, controls: Array | None, steps: int) -> None:
        """Take `steps` steps under controls, shape (steps, controls)."""
        numbers = np.arange(self._taken, self._taken + steps + 1, dtype=np.float64)
        times = self._begun + self.step * numbers
        moved = [np.diff(velocity(times)) / self.step for _, velocity in self._driven]
        # with a step's mean acceleration the velocity is right at every grid time
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
        """The forces of the last step. Those that DART tells of joints lack what contacts, loops,
        limits and dry friction add; where there are such parts they are nan."""
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
        """Forces of joints on the bodies that they move. DART has them along the axes of a node as
        the step began, with the sign of the other body's."""
        made = self.built.joints
        forces = [joint.getWrenchToChildBodyNode().ravel()[3:] for joint in made]
        now = [skeleton.getPositions() for skeleton in self.built.skeletons]
        self._place(self._before)
        turns = [joint.getChildBodyNode().getWorldTransform().rotation() for joint in made]
        self._place(now)
        return [-turn @ force for turn, force in zip(turns, forces, strict=True)]

    def _place(self, positions: Sequence[Array]) -> None:
        """Set the positions of the skeletons."""
        for skeleton, values in zip(self.built.skeletons, positions, strict=True):
            skeleton.setPositions(values)


def _motors(mechanism: Mechanism, built: Built, step: float) -> Iterator[Motor]:
    """The joints that actuators or an armature act on."""
    for number, (joint, made) in enumerate(zip(mechanism.joints, built.joints, strict=True)):
        actuators = actuators_of(mechanism, number)
        rotor = float(joint.armature[0]) / step
        if actuators or rotor:
            made.setDampingCoefficient(0, float(joint.damping[0]) + rotor)
            alone = bool(rotor) or any(any(actuator.bias) for actuator in actuators)
            drawn = float(joint.reference[0])
            yield Motor(made, actuator_force(joint, actuators), drawn, rotor, alone)
