"""The bodies of a mechanism as Exudyn has them: links of one tree, and free bodies by themselves.

A link moves about or along the z axis of its own frame. Of a body with several joints the last one
moves its link; the links before it have no mass.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import Rotation

from plumbob.analytic.reference import Array
from plumbob.engines.mechanism import Body, Joint, Mechanism
from plumbob.engines.peer_model import rotation

AXES = np.eye(3)
# How a free body that carries others, or a ball, moves in a tree: slides along the world's axes,
# then hinges about z, y and x of the body: singular where it has turned by a right angle about y.
TURNS = tuple(("hinge", axis) for axis in AXES[::-1])
CHAINS = MappingProxyType(
    {"free": (*(("slide", axis) for axis in AXES), *TURNS), "ball": TURNS}
)
PARALLEL = 1e-12  # by which directions of unit length differ that are the same
WORLD = -1  # Exudyn's number of the link that the world is


@dataclass(frozen=True)
class Inertia:
    """The inertia of bodies that are welded together, in the frame of what carries them."""

    mass: float = 0.0  # [kg]
    centre: Array = field(default_factory=lambda: np.zeros(3))  # centre of mass [m]
    moments: Array = field(default_factory=lambda: np.zeros((3, 3)))  # about it [kg m^2]

    def __add__(self, other: Inertia) -> Inertia:
        if not self.mass:
            return other
        mass = self.mass + other.mass
        apart = other.centre - self.centre
        spread = self.mass * other.mass / mass * (apart @ apart * AXES - np.outer(apart, apart))
        centre = self.centre + other.mass / mass * apart
        return Inertia(mass, centre, self.moments + other.moments + spread)


@dataclass(frozen=True)
class Frame:
    """A place [m] and an attitude, a matrix, in the frame of what carries it."""

    carrier: int = WORLD  # a link of the tree, the world, or -1 less the number of a free body
    place: Array = field(default_factory=lambda: np.zeros(3))
    turn: Array = field(default_factory=lambda: AXES)

    def within(self, place: Array, turn: Array) -> Frame:
        """The frame at a place in this one, with an attitude in it."""
        return Frame(self.carrier, self.place + self.turn @ place, self.turn @ turn)


@dataclass
class Links:
    """The links of a tree, in the order of its coordinates."""

    parents: list[int] = field(default_factory=list)
    kinds: list[str] = field(default_factory=list)
    places: list[Array] = field(default_factory=list)  # in the parent's frame [m]
    turns: list[Array] = field(default_factory=list)  # in the parent's frame

    def moved(
        self, kind: str, axis: Array, frame: Frame, place: Array, reference: float
    ) -> Frame:
        """Add a link that moves about or along an axis through a place, both of a frame in the
        drawing, where its coordinate is the `reference` [rad] or [m]; returns that frame as the
        link moves it."""
        turn = turned_to(axis)
        if kind == "hinge":  # where the coordinate is 0, so that small ones keep their digits
            joint = frame.within(place, turn @ about_z(-reference))
        else:
            joint = frame.within(place - reference * axis, turn)
        self.parents.append(joint.carrier)
        self.kinds.append(kind)
        self.places.append(joint.place)
        self.turns.append(joint.turn)
        return Frame(len(self.parents) - 1, -turn.T @ place, turn.T)


def turned_to(axis: Array) -> Array:
    """A rotation, a matrix, that turns the z axis to an axis of unit length."""
    return np.asarray(Rotation.align_vectors(axis[None], AXES[2:])[0].as_matrix())


def about_z(angle: float) -> Array:
    """The rotation by an angle [rad] about the z axis, a matrix."""
    return np.asarray(Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix())


@dataclass(frozen=True)
class Bodies:
    """The bodies of a mechanism as Exudyn has them."""

    links: Links
    frames: tuple[Frame, ...]  # one a body
    inertias: Mapping[int, Inertia]  # {carrier: inertia of all bodies welded to it}
    places: tuple[slice, ...]  # coordinates of each joint in the system


def bodies_of(mechanism: Mechanism) -> Bodies:
    """The bodies of a mechanism as Exudyn has them."""
    links, frames = Links(), [Frame()]
    inertias = defaultdict[int, Inertia](Inertia)
    places = dict[int, slice]()
    carrying = _carrying(mechanism)
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        frame = frames[body.parent].within(body.place, rotation(body.attitude))
        for i, joint in enumerate(mechanism.joints):
            if joint.body != number:
                continue
            begin = len(links.parents)
            if joint.kind == "free":  # its coordinates are those of its frame in the world
                frame = Frame(WORLD if number in carrying else WORLD - number)
            if frame.carrier >= WORLD:
                drawn_at = 0.0 if joint.kind in CHAINS else float(joint.reference[0])
                for kind, axis in CHAINS.get(joint.kind, ((joint.kind, joint.axis),)):
                    frame = links.moved(kind, axis, frame, joint.place, drawn_at)
            places[i] = slice(begin, len(links.parents))
        frames.append(frame)
        inertias[frame.carrier] += _inertia(body, frame)
    first = len(links.parents)
    for i, joint in enumerate(mechanism.joints):
        if frames[joint.body].carrier < WORLD:
            places[i] = slice(first, first + 6)
            first += 6
    return Bodies(links, tuple(frames), inertias, tuple(places[i] for i in sorted(places)))


def _inertia(body: Body, frame: Frame) -> Inertia:
    """The inertia of a body in the frame of what carries it; a point has moments of none."""
    moments = np.zeros((3, 3)) if body.point else frame.turn @ body.inertia @ frame.turn.T
    return Inertia(body.mass, frame.place + frame.turn @ body.centre, moments)


def _carrying(mechanism: Mechanism) -> set[int]:
    """The numbers of bodies on which a body with a joint hangs, maybe by others."""
    moved = {joint.body for joint in mechanism.joints}
    carrying = set[int]()
    for number in range(len(mechanism.bodies) - 1, 0, -1):
        if number in moved | carrying:
            carrying.add(mechanism.bodies[number].parent)
    return carrying


def drawn(mechanism: Mechanism) -> list[Array]:
    """The attitude of each body in the drawing, a matrix."""
    turns = [AXES]
    for body in mechanism.bodies[1:]:
        turns.append(turns[body.parent] @ rotation(body.attitude))
    return turns


def movers(mechanism: Mechanism, number: int) -> list[Joint]:
    """The joints that move a body, those of the bodies that carry it among them."""
    own = [joint for joint in mechanism.joints if joint.body == number]
    return movers(mechanism, mechanism.bodies[number].parent) + own if number else own


def norm(vector: Array) -> float:
    """The length of a vector."""
    return float(np.linalg.norm(vector))
