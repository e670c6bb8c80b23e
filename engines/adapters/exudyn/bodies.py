"""The bodies of a mechanism in Exudyn: the links of one kinematic tree, and lone free bodies.

A lone free body is a free body that carries no other body. A link of the tree turns about the z
axis of its frame or slides along it. If a body has several joints, the last joint moves the link of
the body, and each joint before it moves a link without mass.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import Rotation

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.joints import joints_of_body
from plumbob.engines.mechanism import Body, Joint, Mechanism
from plumbob.engines.peer_model import rotation

AXES = np.eye(3)
# A free body that carries others is a chain in the tree: three slides along the world's axes, then
# hinges about z, y and x of the body. A ball is a chain of the same hinges. The hinges are singular
# at a right angle about y.
TURNS = tuple(("hinge", axis) for axis in AXES[::-1])
CHAINS = MappingProxyType(
    {"free": (*(("slide", axis) for axis in AXES), *TURNS), "ball": TURNS}
)
PARALLEL = 1e-12  # largest sine of the angle between axes that are taken for parallel
WORLD = -1  # number of the world among Exudyn's links


@dataclass(frozen=True)
class Inertia:
    """The inertia of bodies that are welded together, in the frame of the link or of the free body
    that carries them."""

    mass: float = 0.0  # [kg]
    centre: Array = field(default_factory=lambda: np.zeros(3))  # centre of mass [m]
    moments: Array = field(default_factory=lambda: np.zeros((3, 3)))
    """The moments of inertia about the centre of mass [kg m^2]."""

    def __add__(self, other: Inertia) -> Inertia:
        """The inertia of both, welded together."""
        if not self.mass:
            return other
        mass = self.mass + other.mass
        offset = other.centre - self.centre
        of_unit_mass = offset @ offset * AXES - np.outer(offset, offset)
        moments_of_offset = self.mass * other.mass / mass * of_unit_mass
        centre = self.centre + other.mass / mass * offset
        return Inertia(mass, centre, self.moments + other.moments + moments_of_offset)


@dataclass(frozen=True)
class Frame:
    """A frame that is fixed on a carrier: its place [m] and its attitude in the carrier's frame."""

    # number of a link of the tree, WORLD, or for a lone free body WORLD minus the body's number
    carrier: int = WORLD
    place: Array = field(default_factory=lambda: np.zeros(3))  # [m], shape (3,)
    turn: Array = field(default_factory=lambda: AXES)  # rotation matrix

    def within(self, place: Array, turn: Array) -> Frame:
        """The frame on the same carrier whose `place` [m] and `turn` are given in this frame."""
        return Frame(self.carrier, self.place + self.turn @ place, self.turn @ turn)


@dataclass
class Links:
    """The links of a tree, in the order of the tree's coordinates."""

    parents: list[int] = field(default_factory=list)  # number of the parent link of each link
    kinds: list[str] = field(default_factory=list)  # kind of the joint that moves each link
    places: list[Array] = field(default_factory=list)  # places in the parent's frame [m]
    turns: list[Array] = field(default_factory=list)  # rotation matrices in the parent's frame

    def add(
        self, kind: str, axis: Array, frame: Frame, place: Array, reference: float
    ) -> Frame:
        """Adds a link that turns about an axis, or slides along it. The axis and the `place` [m]
        that it goes through are given in `frame`, the frame of a body in the reference pose. In
        this pose the link's coordinate is the `reference` [rad] or [m]. Returns the frame of the
        body on the new link."""
        turn = turned_to(axis)
        # The link is placed where its coordinate is 0: Exudyn's coordinate is then the coordinate
        # of the joint, and a small coordinate keeps all its digits.
        if kind == "hinge":
            joint = frame.within(place, turn @ about_z(-reference))
        else:
            joint = frame.within(place - reference * axis, turn)
        self.parents.append(joint.carrier)
        self.kinds.append(kind)
        self.places.append(joint.place)
        self.turns.append(joint.turn)
        return Frame(len(self.parents) - 1, -turn.T @ place, turn.T)


def turned_to(axis: Array) -> Array:
    """A rotation matrix that turns the z axis to an axis of unit length."""
    return np.asarray(Rotation.align_vectors(axis[None], AXES[2:])[0].as_matrix())


def about_z(angle: float) -> Array:
    """The matrix of the rotation by an angle [rad] about the z axis."""
    return np.asarray(Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix())


@dataclass(frozen=True)
class Bodies:
    """The bodies of a mechanism in Exudyn."""

    links: Links
    frames: tuple[Frame, ...]  # frame of each body
    inertias: Mapping[int, Inertia]  # {carrier: inertia of all bodies welded to it}
    places: tuple[slice, ...]  # place of each joint's coordinates among Exudyn's


def bodies_of(mechanism: Mechanism) -> Bodies:
    """The bodies of a mechanism in Exudyn."""
    links = Links()
    frames = [Frame()]
    inertias = defaultdict[int, Inertia](Inertia)
    places = dict[int, slice]()
    carriers = _bodies_that_carry(mechanism)
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        frame = frames[body.parent].within(body.place, rotation(body.attitude))
        for joint_number in joints_of_body(mechanism, number):
            joint = mechanism.joints[joint_number]
            first = len(links.parents)
            if joint.kind == "free":  # its coordinates are those of its body in the world
                frame = Frame(WORLD if number in carriers else WORLD - number)
            if frame.carrier >= WORLD:
                frame = _add_links(links, joint, frame)
            places[joint_number] = slice(first, len(links.parents))
        frames.append(frame)
        inertias[frame.carrier] += _inertia(body, frame)
    first = len(links.parents)  # the coordinates of lone free bodies follow those of the tree
    for joint_number, joint in enumerate(mechanism.joints):
        if frames[joint.body].carrier < WORLD:
            places[joint_number] = slice(first, first + 6)
            first += 6
    ordered_places = tuple(places[joint_number] for joint_number in sorted(places))
    return Bodies(links, tuple(frames), inertias, ordered_places)


def _add_links(links: Links, joint: Joint, frame: Frame) -> Frame:
    """Adds the links of a joint to a tree; returns the frame of the joint's body on the last link.
    `frame` is the frame of the body in the reference pose."""
    if joint.kind not in CHAINS:
        reference = float(joint.reference[0])
        return links.add(joint.kind, joint.axis, frame, joint.place, reference)
    for kind, axis in CHAINS[joint.kind]:
        frame = links.add(kind, axis, frame, joint.place, 0.0)
    return frame


def _inertia(body: Body, frame: Frame) -> Inertia:
    """The inertia of a body in the frame of its carrier. A point mass has no moments of inertia."""
    moments = np.zeros((3, 3)) if body.point else frame.turn @ body.inertia @ frame.turn.T
    return Inertia(body.mass, frame.place + frame.turn @ body.centre, moments)


def _bodies_that_carry(mechanism: Mechanism) -> set[int]:
    """The numbers of the bodies that carry a body with a joint, directly or through others."""
    moving = {joint.body for joint in mechanism.joints}
    carriers = set[int]()
    for number in range(len(mechanism.bodies) - 1, 0, -1):
        if number in moving or number in carriers:
            carriers.add(mechanism.bodies[number].parent)
    return carriers


def moving_joints(mechanism: Mechanism, number: int) -> list[Joint]:
    """The joints that move a body: the joints of all bodies that carry it, then the joints of the
    body itself."""
    if number == 0:
        return []
    joints = [mechanism.joints[joint] for joint in joints_of_body(mechanism, number)]
    return moving_joints(mechanism, mechanism.bodies[number].parent) + joints


def norm(vector: Array) -> float:
    """The length of a vector."""
    return float(np.linalg.norm(vector))
