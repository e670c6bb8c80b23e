"""Builds the Pinocchio model of a mechanism, and computes the accelerations of the mechanism.

A joint of Pinocchio moves one body. If a body has several joints, the last joint moves the body,
and each joint before it moves a body without mass. A free joint is two joints of Pinocchio: one
that moves a massless body along the world's axes, and a ball that turns the body there. The rates
of Pinocchio are the rates of the mechanism's state, in the same order.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.joints import (
    ONE_AXIS,
    TURNING,
    joint_name,
    joint_places,
    joints_of_body,
)
from plumbob.engines.adapters.refusals import names_of, refuse
from plumbob.engines.joint_forces import (
    JointForce,
    actuators_of,
    idle_controls,
    passive_and_actuator_force,
)
from plumbob.engines.mechanism import Joint, Mechanism, is_constant
from plumbob.engines.peer_model import rotation

CLOSING = 50.0  # [1/s] rate at which the gap of a loop closes, critically damped
# Accuracy, mu and largest number of iterations of the solver for loops
PROXIMAL = (1e-14, 1e-10, 50)
NEAR = 1e-6  # [s] half the interval of the central difference of a prescribed velocity


@dataclass(frozen=True)
class Driven:
    """A joint with one coordinate on which a spring, a damper or actuators act."""

    place: int  # number of the coordinate
    degree: int  # number of the rate
    force: JointForce


class Dynamics:
    """Computes the accelerations of a mechanism. Raises Unsupported if Pinocchio cannot express a
    feature of the mechanism."""

    def __init__(self, mechanism: Mechanism) -> None:
        refuse(refused_features(mechanism))
        self.mechanism = mechanism
        self.model = pinocchio.Model()
        self.carried = pinocchio.Model()  # model whose weights are those that forces carry
        frames = _add_trees(mechanism, self.model, self.carried)
        armatures = [joint.armature for joint in mechanism.joints]
        self.model.armature = np.concatenate([[], *armatures])
        self.carries = any(body.carried for body in mechanism.bodies)
        self.weights = self.carried.createData()
        self.data = self.model.createData()
        self.driven, self.damping = _driven_joints(mechanism)
        self.attitudes = tuple(_attitudes(mechanism))
        self.reference, self.order = _coordinates(mechanism, self.attitudes)
        self.idle = idle_controls(mechanism)  # controls that are zero
        places = joint_places(mechanism.joints)
        self.held = [
            (place_of_rates.start, joint.velocity)
            for joint, (_, place_of_rates) in zip(mechanism.joints, places, strict=True)
            if joint.velocity is not None
        ]
        # Joints whose acceleration is taken from differences of their velocity. Most platforms turn
        # at a constant rate, and need none.
        self.accelerated = [
            (degree, velocity) for degree, velocity in self.held if not is_constant(velocity)
        ]
        self.same_coordinates = not (self.attitudes or self.reference.any())
        self.loops = pinocchio.StdVec_RigidConstraintModel()
        self.loop_data = pinocchio.StdVec_RigidConstraintData()
        for constraint in _constraints(mechanism, self.model, frames):
            self.loops.append(constraint)
            self.loop_data.append(constraint.createData())
        pinocchio.initConstraintDynamics(self.model, self.data, self.loops, self.loop_data)

    @cached_property
    def free(self) -> Array:
        """The numbers of the rates whose motion is not prescribed."""
        return np.setdiff1d(np.arange(self.model.nv), [degree for degree, _ in self.held])

    def configured(self, qpos: Array) -> Array:
        """Pinocchio's coordinates from the mechanism's. Quaternions are normalised, and their
        scalar comes last."""
        if self.same_coordinates:
            return qpos
        q = qpos - self.reference
        for first, _ in self.attitudes:
            attitude = q[first : first + 4]
            attitude /= math.sqrt(attitude @ attitude)
        return np.asarray(q[self.order])

    def acceleration(self, time: float, qpos: Array, qvel: Array, controls: Any) -> Array:
        """The accelerations, shape (nv,), in a state at a time [s] under controls."""
        q = self.configured(qpos)
        forces = self.forces(q, qpos, qvel, controls)
        state = (self.model, self.data, q, qvel)
        if self.loops:
            settings = pinocchio.ProximalSettings(*PROXIMAL)
            acceleration = pinocchio.constraintDynamics(
                *state, forces, self.loops, self.loop_data, settings
            )
        elif self.held:
            acceleration = self._with_prescribed(time, q, qvel, forces)
        else:
            acceleration = pinocchio.aba(*state, forces)
        return np.asarray(acceleration)

    def forces(self, q: Array, qpos: Array, qvel: Array, controls: Sequence[float]) -> Array:
        """The generalised forces of springs, dampers, actuators and carried weights, shape (nv,).
        `q` are Pinocchio's coordinates, `qpos` the mechanism's."""
        forces = -self.damping * qvel
        for joint in self.driven:
            coordinate = float(qpos[joint.place])
            rate = float(qvel[joint.degree])
            forces[joint.degree] = joint.force(coordinate, rate, controls)
        if self.carries:
            forces += pinocchio.computeGeneralizedGravity(self.carried, self.weights, q)
        return forces

    def _with_prescribed(self, time: float, q: Array, v: Array, forces: Array) -> Array:
        """The accelerations if the motion of some joints is prescribed. The accelerations of the
        other joints are those for which inverse dynamics returns the forces that act on these
        joints."""
        acceleration = np.zeros(self.model.nv)
        for degree, velocity in self.accelerated:
            before, after = velocity(np.array([time - NEAR, time + NEAR])).tolist()
            acceleration[degree] = (after - before) / (2.0 * NEAR)
        prescribed_forces = pinocchio.rnea(self.model, self.data, q, v, acceleration)
        missing_forces = forces - prescribed_forces
        if len(self.free) == 1:
            (free,) = self.free
            inertia = pinocchio.crba(self.model, self.data, q)[free, free]
            acceleration[free] = missing_forces[free] / inertia
        else:
            inertia = self.inertia(q)
            acceleration[self.free] = np.linalg.solve(inertia, missing_forces[self.free])
        return acceleration

    def inertia(self, q: Array) -> Array:
        """The mass matrix of the rates that are not prescribed, shape (free, free)."""
        # Pinocchio fills only the upper triangle of the mass matrix.
        upper = np.triu(pinocchio.crba(self.model, self.data, q))
        inertia = upper + np.triu(upper, 1).T
        return np.asarray(inertia[np.ix_(self.free, self.free)])


def refused_features(mechanism: Mechanism) -> Iterator[str]:
    """Names the features of a mechanism that Pinocchio, or this builder, cannot express."""
    yield from (part.name for part in mechanism.not_expressed)
    for touch in mechanism.touching:
        names = names_of(mechanism, touch)
        yield f"contact of {names}: forward dynamics has only constraints that always hold"
    for joint in mechanism.joints:
        name = joint_name(mechanism, joint)
        if joint.limits is not None or np.any(joint.friction_loss):
            yield f"limit or dry friction of joint {name}"
        if joint.stiffness and joint.kind not in ONE_AXIS:
            yield f"spring of joint {name}, which is a {joint.kind} joint"
        if joint.velocity is not None and mechanism.loops:
            yield f"prescribed motion of joint {name} beside a loop"


def _driven_joints(mechanism: Mechanism) -> tuple[list[Driven], Array]:
    """The hinges and slides on which springs, dampers or actuators act, and the damping of all
    degrees of freedom, shape (nv,)."""
    driven = []
    damping = list[Array]()
    for number, (place, place_of_rates) in enumerate(joint_places(mechanism.joints)):
        joint = mechanism.joints[number]
        actuators = actuators_of(mechanism, number)
        acts = bool(joint.stiffness or np.any(joint.damping) or actuators)
        damping.append(joint.damping)
        if acts and joint.kind in ONE_AXIS:
            force = passive_and_actuator_force(joint, actuators)
            driven.append(Driven(place.start, place_of_rates.start, force))
    return driven, np.concatenate([[], *damping])


def _attitudes(mechanism: Mechanism) -> Iterator[tuple[int, int]]:
    """For each quaternion, the number of its first coordinate, and the number of the first rate of
    its angular velocity."""
    places = joint_places(mechanism.joints)
    for joint, (place, place_of_rates) in zip(mechanism.joints, places, strict=True):
        if joint.kind in TURNING:
            yield place.stop - 4, place_of_rates.stop - 3


def _coordinates(
    mechanism: Mechanism, attitudes: Sequence[tuple[int, int]]
) -> tuple[Array, Any]:
    """The mechanism's coordinates at which Pinocchio's coordinates are 0, shape (nq,), and for each
    of Pinocchio's coordinates its number among the mechanism's, shape (nq,)."""
    references = [
        joint.reference if joint.kind in ONE_AXIS else 0.0 * joint.reference
        for joint in mechanism.joints
    ]
    reference = np.concatenate([[], *references])
    order = np.arange(len(reference))
    for first, _ in attitudes:
        order[first : first + 4] = np.roll(order[first : first + 4], -1)
    return reference, order


def _add_trees(mechanism: Mechanism, model: Any, carried: Any) -> list[tuple[int, Any]]:
    """Adds the joints of a mechanism to both models. `model` gets the bodies, and `carried` gets
    bodies with the part of the mass whose weight is carried. Returns for each body the number of
    the joint that moves it, and the body's frame in the frame of that joint."""
    frames = [(0, transform(np.zeros(3)))]
    model.gravity.linear = mechanism.gravity
    carried.gravity.linear = mechanism.gravity
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        above, frame = frames[body.parent]
        frame = frame * transform(body.place, body.attitude)
        for joint_number in joints_of_body(mechanism, number):
            joint = mechanism.joints[joint_number]
            above, frame = _add_joint((model, carried), joint_number, joint, above, frame)
        moments = np.zeros((3, 3)) if body.point else body.inertia
        inertia = pinocchio.Inertia(body.mass, body.centre, moments)
        model.appendBodyToJoint(above, inertia, frame)
        carried_mass = body.carried * body.mass
        weight = pinocchio.Inertia(carried_mass, body.centre, np.zeros((3, 3)))
        carried.appendBodyToJoint(above, weight, frame)
        frames.append((above, frame))
    return frames


def _add_joint(
    models: Sequence[Any], number: int, joint: Joint, above: int, frame: Any
) -> tuple[int, Any]:
    """Adds a joint with a number to all models, behind the joint `above`. In the drawing, the body
    of the joint has the `frame` in the frame of `above`. Returns the number of the joint that moves
    the body, and the body's frame in the frame of that joint."""
    if joint.kind == "free":  # the coordinates of the joint are those of the body in the world
        frame = transform(np.zeros(3))
    joint_frame = frame * transform(joint.place)
    for part, joint_model in enumerate(_joint_models(joint)):
        numbers = [
            model.addJoint(above, joint_model, joint_frame, f"{number} {part}")
            for model in models
        ]
        above = numbers[0]  # all models number their joints alike
        joint_frame = transform(np.zeros(3))
    return above, transform(-joint.place)


def _joint_models(joint: Joint) -> tuple[Any, ...]:
    """Pinocchio's joints that together move like a joint, one behind the other."""
    match joint.kind:
        case "hinge":
            return (pinocchio.JointModelRevoluteUnaligned(joint.axis),)
        case "slide":
            return (pinocchio.JointModelPrismaticUnaligned(joint.axis),)
        case "ball":
            return (pinocchio.JointModelSpherical(),)
    return pinocchio.JointModelTranslation(), pinocchio.JointModelSpherical()


def transform(place: Array, attitude: Array | None = None) -> Any:
    """Pinocchio's transform to a place [m], with an attitude, a quaternion, or without a
    rotation."""
    return pinocchio.SE3(np.eye(3) if attitude is None else rotation(attitude), place)


def _constraints(
    mechanism: Mechanism, model: Any, frames: Sequence[tuple[int, Any]]
) -> Iterator[Any]:
    """Pinocchio's constraints that close the loops of a mechanism."""
    kinds = {
        "connect": pinocchio.ContactType.CONTACT_3D,
        "weld": pinocchio.ContactType.CONTACT_6D,
    }
    for loop in mechanism.loops:
        (joint, frame), (other_joint, other_frame) = (frames[body] for body in loop.bodies)
        place, other_place = loop.places
        turn = loop.attitude if loop.kind == "weld" else None
        constraint = pinocchio.RigidConstraintModel(
            kinds[loop.kind],
            model,
            joint,
            frame * transform(place, turn),
            other_joint,
            other_frame * transform(other_place),
            pinocchio.ReferenceFrame.LOCAL,
        )
        gains = constraint.m_baumgarte_parameters
        gains.Kp = CLOSING**2
        gains.Kd = 2.0 * CLOSING
        yield constraint
