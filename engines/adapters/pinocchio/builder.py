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
from plumbob.engines.adapters.refusals import names_of
from plumbob.engines.joint_forces import (
    JointForce,
    actuators_of,
    idle_controls,
    passive_and_actuator_force,
)
from plumbob.engines.mechanism import Joint, Mechanism, is_constant
from plumbob.engines.method import Unsupported
from plumbob.engines.peer_model import rotation

HINGED = ("hinge", "slide")  # kinds of joint with one coordinate
CLOSING = 50.0  # [1/s] rate at which the gap of a loop closes, critically damped
PROXIMAL = (
    1e-14,
    1e-10,
    50,
)  # accuracy, mu and largest number of iterations of the loop solver
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
        for feature in refused(mechanism):
            raise Unsupported(f"feature {feature}")
        self.mechanism = mechanism
        self.model = pinocchio.Model()
        self.carried = pinocchio.Model()  # model whose weights are those that forces carry
        frames = _trees(mechanism, self.model, self.carried)
        self.model.armature = np.concatenate([[], *(x.armature for x in mechanism.joints)])
        self.carries = any(body.carried for body in mechanism.bodies)
        self.weights = self.carried.createData()
        self.data = self.model.createData()
        self.driven, self.damping = _forces(mechanism)
        self.attitudes = tuple(_attitudes(mechanism))
        self.drawn, self.order = _coordinates(mechanism, self.attitudes)
        self.uncontrolled = idle_controls(mechanism)
        self.held = [
            (degree, joint.velocity)
            for joint, _, degree in numbered(mechanism)
            if joint.velocity is not None
        ]
        # Most platforms turn at a constant rate: no difference of it is taken in each stage.
        self.accelerated = [
            (degree, velocity) for degree, velocity in self.held if not is_constant(velocity)
        ]
        self.as_drawn = not (self.attitudes or self.drawn.any())
        self.loops = pinocchio.StdVec_RigidConstraintModel()
        for constraint in _loops(mechanism, self.model, frames):
            self.loops.append(constraint)
        self.closing = pinocchio.StdVec_RigidConstraintData()
        for constraint in self.loops:
            self.closing.append(constraint.createData())
        pinocchio.initConstraintDynamics(self.model, self.data, self.loops, self.closing)

    @cached_property
    def free(self) -> Array:
        """The numbers of the rates whose motion is not prescribed."""
        return np.setdiff1d(np.arange(self.model.nv), [degree for degree, _ in self.held])

    def configured(self, qpos: Array) -> Array:
        """Pinocchio's coordinates from the mechanism's. Quaternions are normalised, and their
        scalar comes last."""
        if self.as_drawn:
            return qpos
        q = qpos - self.drawn
        for first, _ in self.attitudes:
            attitude = q[first : first + 4]
            attitude /= math.sqrt(attitude @ attitude)
        return np.asarray(q[self.order])

    def acceleration(self, time: float, qpos: Array, qvel: Array, controls: Any) -> Array:
        """The accelerations, shape (nv,), in a state at a time [s] under controls."""
        q = self.configured(qpos)
        forces = self.forces(q, qpos, qvel, controls)
        if self.loops:
            with_loops = (self.loops, self.closing, pinocchio.ProximalSettings(*PROXIMAL))
            found = pinocchio.constraintDynamics(
                self.model, self.data, q, qvel, forces, *with_loops
            )
        elif self.held:
            found = self._beside_held(time, q, qvel, forces)
        else:
            found = pinocchio.aba(self.model, self.data, q, qvel, forces)
        return np.asarray(found)

    def forces(self, q: Array, qpos: Array, qvel: Array, controls: Sequence[float]) -> Array:
        """The generalised forces of springs, dampers, actuators and carried weights, shape (nv,).
        `q` are Pinocchio's coordinates, `qpos` the mechanism's."""
        forces = -self.damping * qvel
        for joint in self.driven:
            place, rate = float(qpos[joint.place]), float(qvel[joint.degree])
            forces[joint.degree] = joint.force(place, rate, controls)
        if self.carries:
            forces += pinocchio.computeGeneralizedGravity(self.carried, self.weights, q)
        return forces

    def _beside_held(self, time: float, q: Array, v: Array, forces: Array) -> Array:
        """The accelerations if the motion of some joints is prescribed. The accelerations of the
        other joints are those for which inverse dynamics returns the forces that act on these
        joints."""
        found = np.zeros(self.model.nv)
        for degree, velocity in self.accelerated:
            before, after = velocity(np.array([time - NEAR, time + NEAR])).tolist()
            found[degree] = (after - before) / (2.0 * NEAR)
        lacking = forces - pinocchio.rnea(self.model, self.data, q, v, found)
        if len(self.free) == 1:
            (free,) = self.free
            inertia = pinocchio.crba(self.model, self.data, q)[free, free]
            found[free] = lacking[free] / inertia
        else:
            found[self.free] = np.linalg.solve(self.inertia(q), lacking[self.free])
        return found

    def inertia(self, q: Array) -> Array:
        """The mass matrix of the rates that are not prescribed, shape (free, free)."""
        upper = np.triu(pinocchio.crba(self.model, self.data, q))
        return np.asarray((upper + np.triu(upper, 1).T)[np.ix_(self.free, self.free)])


def numbered(mechanism: Mechanism) -> Iterator[tuple[Joint, int, int]]:
    """Each joint with the numbers of its first coordinate and its first rate."""
    place = degree = 0
    for joint in mechanism.joints:
        yield joint, place, degree
        place += len(joint.reference)
        degree += len(joint.damping)


def refused(mechanism: Mechanism) -> Iterator[str]:
    """Names the features of a mechanism that Pinocchio, or this builder, cannot express."""
    yield from (part.name for part in mechanism.not_expressed)
    for touch in mechanism.touching:
        names = names_of(mechanism, touch)
        yield f"contact of {names}: forward dynamics has constraints that hold always, no others"
    for joint in mechanism.joints:
        name = joint.name or f"of body {mechanism.bodies[joint.body].name}"
        if joint.limits is not None or np.any(joint.friction_loss):
            yield f"limit or dry friction of joint {name}"
        if joint.stiffness and joint.kind not in HINGED:
            yield f"spring of joint {name}, which is a {joint.kind} joint"
        if joint.velocity is not None and mechanism.loops:
            yield f"prescribed motion of joint {name} beside a loop"


def _forces(mechanism: Mechanism) -> tuple[list[Driven], Array]:
    """The hinges and slides on which springs, dampers or actuators act, and the damping of all
    degrees of freedom, shape (nv,)."""
    driven = []
    damping = list[Array]()
    for number, (joint, place, degree) in enumerate(numbered(mechanism)):
        actuators = actuators_of(mechanism, number)
        acts = bool(joint.stiffness or np.any(joint.damping) or actuators)
        damping.append(joint.damping)
        if acts and joint.kind in HINGED:
            driven.append(Driven(place, degree, passive_and_actuator_force(joint, actuators)))
    return driven, np.concatenate([[], *damping])


def _attitudes(mechanism: Mechanism) -> Iterator[tuple[int, int]]:
    """For each quaternion, the number of its first coordinate, and the number of the first rate of
    its angular velocity."""
    for joint, place, degree in numbered(mechanism):
        if joint.kind == "ball":
            yield place, degree
        elif joint.kind == "free":
            yield place + 3, degree + 3


def _coordinates(
    mechanism: Mechanism, attitudes: Sequence[tuple[int, int]]
) -> tuple[Array, Any]:
    """The mechanism's coordinates at which Pinocchio's coordinates are 0, shape (nq,), and for each
    of Pinocchio's coordinates its number among the mechanism's, shape (nq,)."""
    drawn = [
        joint.reference if joint.kind in HINGED else 0.0 * joint.reference
        for joint in mechanism.joints
    ]
    zero = np.concatenate([[], *drawn])
    order = np.arange(len(zero))
    for first, _ in attitudes:
        order[first : first + 4] = np.roll(order[first : first + 4], -1)
    return zero, order


def _trees(mechanism: Mechanism, model: Any, carried: Any) -> list[tuple[int, Any]]:
    """Adds the joints of a mechanism to both models. `model` gets the bodies, and `carried` gets
    bodies with the part of the mass whose weight is carried. Returns for each body the number of
    the joint that moves it, and the body's frame in the frame of that joint."""
    frames = [(0, placed(np.zeros(3)))]
    for each in (model, carried):
        each.gravity.linear = mechanism.gravity
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        above, frame = frames[body.parent]
        frame = frame * placed(body.place, body.attitude)
        for i, joint in enumerate(mechanism.joints):
            if joint.body == number:
                above, frame = _jointed((model, carried), i, joint, above, frame)
        moments = np.zeros((3, 3)) if body.point else body.inertia
        inertia = pinocchio.Inertia(body.mass, body.centre, moments)
        model.appendBodyToJoint(above, inertia, frame)
        weight = pinocchio.Inertia(body.carried * body.mass, body.centre, 0.0 * moments)
        carried.appendBodyToJoint(above, weight, frame)
        frames.append((above, frame))
    return frames


def _jointed(
    models: Sequence[Any], number: int, joint: Joint, above: int, frame: Any
) -> tuple[int, Any]:
    """Adds a joint with a number to all models, behind the joint `above`. In the drawing, the body
    of the joint has the `frame` in the frame of `above`. Returns the number of the joint that moves
    the body, and the body's frame in the frame of that joint."""
    if joint.kind == "free":  # the coordinates of the joint are those of the body in the world
        frame = placed(np.zeros(3))
    at = frame * placed(joint.place)
    for part, moves in enumerate(_moves(joint)):
        (above, *_) = [each.addJoint(above, moves, at, f"{number} {part}") for each in models]
        at = placed(np.zeros(3))
    return above, placed(-joint.place)


def _moves(joint: Joint) -> tuple[Any, ...]:
    """Pinocchio's joints that together move like a joint, one behind the other."""
    match joint.kind:
        case "hinge":
            return (pinocchio.JointModelRevoluteUnaligned(joint.axis),)
        case "slide":
            return (pinocchio.JointModelPrismaticUnaligned(joint.axis),)
        case "ball":
            return (pinocchio.JointModelSpherical(),)
    return pinocchio.JointModelTranslation(), pinocchio.JointModelSpherical()


def placed(place: Array, attitude: Array | None = None) -> Any:
    """Pinocchio's transform to a place [m], with an attitude, a quaternion, or without a
    rotation."""
    return pinocchio.SE3(np.eye(3) if attitude is None else rotation(attitude), place)


def _loops(
    mechanism: Mechanism, model: Any, frames: Sequence[tuple[int, Any]]
) -> Iterator[Any]:
    """Pinocchio's constraints that close the loops of a mechanism."""
    kinds = {
        "connect": pinocchio.ContactType.CONTACT_3D,
        "weld": pinocchio.ContactType.CONTACT_6D,
    }
    for loop in mechanism.loops:
        (first, one), (second, other) = (frames[i] for i in loop.bodies)
        here = one * placed(loop.places[0], loop.attitude if loop.kind == "weld" else None)
        there = other * placed(loop.places[1])
        local = pinocchio.ReferenceFrame.LOCAL
        made = pinocchio.RigidConstraintModel(
            kinds[loop.kind], model, first, here, second, there, local
        )
        gains = made.m_baumgarte_parameters
        gains.Kp, gains.Kd = CLOSING**2, 2.0 * CLOSING
        yield made
