"""The plane in which a mechanism moves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.reference_pose import ReferencePose
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Unsupported
from plumbob.engines.peer_model import rotation
from plumbob.engines.stepper import State

# Directions and points coincide if they differ by less, relative to a unit vector or in metres. The
# rounding of a quaternion is 1e-16, and no mechanism leaves its plane by so little on purpose.
CLOSE = 1e-9


@dataclass(frozen=True)
class Plane:
    """A plane in the world: unit vectors to the right, up, and along the normal, shape (3,) each.
    Angles in the plane count about the normal."""

    right: Array
    up: Array
    normal: Array

    def flat(self, vector: Array) -> complex:
        """The part of a vector in the plane, as right + i up."""
        return complex(self.right @ vector, self.up @ vector)

    def across(self, vector: Array) -> float:
        """The component of a vector along the normal."""
        return float(self.normal @ vector)

    def lifted(self, value: complex) -> Array:
        """A vector of the plane, right + i up, as a vector of the world, shape (3,)."""
        return value.real * self.right + value.imag * self.up


def plane_of(mechanism: Mechanism, start: State, drawn: ReferencePose) -> Plane:
    """The plane of a mechanism's motion. Its normal is the axis of the hinges. Without hinges the
    plane contains the normal of a floor, gravity, the velocities of the start and the slides that
    guide a body, in this order. Raises Unsupported if a hinge turns out of the plane."""
    hinges = [
        joint for joint in mechanism.joints if joint.kind == "hinge" and joint.velocity is None
    ]
    lines = [line for line in _lines(mechanism, start, drawn) if np.linalg.norm(line) > CLOSE]
    if not hinges:
        up = lines[0] / np.linalg.norm(lines[0])
        right = _perpendicular(lines, up)
        return Plane(right, up, np.cross(right, up))
    normal = drawn.axis(hinges[0])
    for hinge in hinges:
        axis = drawn.axis(hinge)
        if np.abs(axis - (axis @ normal) * normal).max() > CLOSE:
            raise Unsupported(f"pymunk moves in a plane, and {hinge.name} turns out of it")
    up = _perpendicular(lines, normal)
    right = np.cross(up, normal)
    sign = np.sign(right[np.argmax(np.abs(right))])
    return Plane(sign * right, up, sign * normal)


def _perpendicular(lines: Sequence[Array], axis: Array) -> Array:
    """A unit vector perpendicular to `axis`: the perpendicular part of the first line that is not
    along the axis."""
    for line in lines:
        part = line - (line @ axis) * axis
        length = float(np.linalg.norm(part))
        if length > CLOSE * float(np.linalg.norm(line)):
            return np.asarray(part / length)
    raise AssertionError("the axes of the world are among the lines")


def _lines(mechanism: Mechanism, start: State, drawn: ReferencePose) -> Iterator[Array]:
    """Yields directions in which something acts or moves. The first ones become up and right."""
    for touch in mechanism.touching:
        for shape in (mechanism.shapes[number] for number in touch.shapes):
            if shape.kind == "plane":
                yield drawn.turns[shape.body] @ rotation(shape.attitude)[:, 2]
    for joint in mechanism.joints:
        if joint.velocity is not None:
            yield drawn.axis(joint)
    yield -mechanism.gravity
    slides = [
        (number, joint)
        for number, joint in enumerate(mechanism.joints)
        if joint.kind == "slide"
    ]
    for body in range(len(mechanism.bodies)):
        velocities = [
            drawn.axis(joint) * start.qvel[number]
            for number, joint in slides
            if joint.body == body
        ]
        yield np.sum(velocities, axis=0) if velocities else np.zeros(3)
    bodies_of_joints = [joint.body for joint in mechanism.joints]
    guides = [joint for _, joint in slides if bodies_of_joints.count(joint.body) == 1]
    yield from map(drawn.axis, guides)
    yield from (drawn.axis(joint) for _, joint in slides)
    yield from np.eye(3)[[2, 0, 1]]  # up, right and across, if nothing above decides
