"""A mechanism as replays draw it: its bodies, joints and solids, and their places in a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.mechanism import Joint, JointKind, Mechanism

if TYPE_CHECKING:  # scipy takes long to load
    from scipy.spatial.transform import Rotation

# number of coordinates of a joint
JOINT_WIDTHS = MappingProxyType({"hinge": 1, "slide": 1, "ball": 4, "free": 7})
DOWN = np.array([0.0, 0.0, -1.0])  # direction of gravity in the picture if there is no gravity


@dataclass(frozen=True)
class Solid:
    """A convex solid of a body: the convex hull of points [m], shape (n, 3), thickened by a radius
    [m]. The points are in the frame of the body. A floor has no end: its points are its origin, and
    two more points along its axes."""

    body: int
    points: Array
    radius: float
    colour: tuple[float, float, float]  # red, green and blue, from 0 to 1
    floor: bool = False


@dataclass(frozen=True)
class DrawnJoint:
    """A joint, as in a mechanism, without its forces."""

    name: str
    kind: JointKind
    axis: Array
    place: Array
    reference: Array


@dataclass(frozen=True)
class DrawnBody:
    """A body, as in a mechanism, with its joints and without its inertia."""

    name: str
    parent: int
    place: Array
    attitude: Array
    centre: Array
    joints: tuple[DrawnJoint, ...]


@dataclass(frozen=True)
class DrawnMechanism:
    """The parts of a mechanism that a replay draws. The solids of bodies that cannot move belong to
    the world, which is body 0."""

    bodies: tuple[DrawnBody, ...]
    solids: tuple[Solid, ...]
    # two bodies, and the points of both that coincide [m]
    loops: tuple[tuple[tuple[int, int], tuple[Array, Array]], ...]
    up: Array  # direction against gravity, unit length, shape (3,)

    @property
    def joints(self) -> tuple[DrawnJoint, ...]:
        """The joints in the order of their coordinates."""
        return tuple(joint for body in self.bodies for joint in body.joints)

    @property
    def quaternions(self) -> tuple[slice, ...]:
        """The coordinates that are quaternions."""
        first = 0
        places = []
        for joint in self.joints:
            first += JOINT_WIDTHS[joint.kind]
            if joint.kind in ("ball", "free"):
                places.append(slice(first - 4, first))
        return tuple(places)


@dataclass(frozen=True)
class SceneDrawing:
    """The mechanism of a scene, and coordinates of its motion in the engine that compiles its model
    file, at equal distances of time from the start to the end, shape (n, coordinates)."""

    mechanism: DrawnMechanism
    coordinates: Array


def drawn_mechanism(mechanism: Mechanism, solids: Sequence[Solid]) -> DrawnMechanism:
    """Returns the parts of a mechanism that a replay draws, with these solids."""
    joints: list[list[Joint]] = [[] for _ in mechanism.bodies]
    for joint in mechanism.joints:
        joints[joint.body].append(joint)
    pull = mechanism.gravity if np.any(mechanism.gravity) else DOWN
    return DrawnMechanism(
        bodies=tuple(
            DrawnBody(
                body.name,
                body.parent,
                body.place,
                body.attitude,
                body.centre,
                tuple(
                    DrawnJoint(j.name, j.kind, j.axis, j.place, j.reference)
                    for j in joints[number]
                ),
            )
            for number, body in enumerate(mechanism.bodies)
        ),
        solids=tuple(solids),
        loops=tuple((loop.bodies, loop.places) for loop in mechanism.loops),
        up=-pull / np.linalg.norm(pull),
    )


@dataclass(frozen=True)
class Frames:
    """The frames of all bodies at n times."""

    places: list[Array]  # origins [m], shape (n, 3) for each body
    attitudes: list[Rotation]  # n attitudes for each body

    def placed(self, body: int, points: Array) -> Array:
        """Returns points of a body [m], shape (k, 3), in the world, shape (n, k, 3)."""
        turned = np.einsum("nij,kj->nki", self.attitudes[body].as_matrix(), points)
        return np.asarray(self.places[body][:, None] + turned)


def frames(mechanism: DrawnMechanism, coordinates: Array) -> Frames:
    """Returns the frames of all bodies at coordinates, shape (n, coordinates)."""
    from scipy.spatial.transform import Rotation

    count = len(coordinates)
    places = [np.zeros((count, 3))]
    attitudes = [Rotation.identity(count)]
    first = 0
    for body in mechanism.bodies[1:]:
        parent = attitudes[body.parent]
        place = places[body.parent] + parent.apply(body.place)
        attitude = parent * Rotation.from_quat(body.attitude, scalar_first=True)
        for joint in body.joints:
            values = coordinates[:, first : first + JOINT_WIDTHS[joint.kind]]
            first += JOINT_WIDTHS[joint.kind]
            if joint.kind == "free":
                place = values[:, :3]
                attitude = Rotation.from_quat(values[:, 3:], scalar_first=True)
            elif joint.kind == "slide":
                place = place + attitude.apply((values - joint.reference) * joint.axis)
            else:
                if joint.kind == "ball":
                    turn = Rotation.from_quat(values, scalar_first=True)
                else:
                    turn = Rotation.from_rotvec((values - joint.reference) * joint.axis)
                anchor = place + attitude.apply(joint.place)
                attitude = attitude * turn
                place = anchor - attitude.apply(joint.place)
        places.append(place)
        attitudes.append(attitude)
    return Frames(places, attitudes)
