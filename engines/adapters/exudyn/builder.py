"""The Exudyn system of a mechanism: one kinematic tree of hinges and slides, a rigid body for each
free body that carries no other, and constraints that close loops and prescribe motions.

A link of Exudyn's tree moves about or along the z axis of its own frame. Of a body with several
joints the last one moves its link; the links before it have no mass.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import exudyn
import numpy as np
from exudyn import itemInterface as items
from scipy.spatial.transform import Rotation

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.exudyn.motors import joint_forces
from plumbob.engines.adapters.refusals import refused_parts
from plumbob.engines.mechanism import Joint, Loop, Mechanism
from plumbob.engines.method import Unsupported
from plumbob.engines.peer_model import rotation
from plumbob.models.idealisations import Velocity
from plumbob.models.model_file import Controls

AXES = np.eye(3)
TYPES = MappingProxyType(
    {"hinge": exudyn.JointType.RevoluteZ, "slide": exudyn.JointType.PrismaticZ}
)
# How a free body that carries others, or a ball, moves in a tree: slides along the world's axes,
# then hinges about z, y and x of the body: singular where it has turned by a right angle about y.
TURNS = tuple(("hinge", axis) for axis in AXES[::-1])
CHAINS = MappingProxyType(
    {"free": (*(("slide", axis) for axis in AXES), *TURNS), "ball": TURNS}
)
# Inertia of a rotor that imposes a constant velocity, over that of all that it moves: no bit of
# the velocity changes.
HOLDING = 1e15
PARALLEL = 1e-12  # by which directions of unit length differ that are the same
WORLD = -1  # Exudyn's number of the link that the world is


@dataclass(frozen=True)
class Inertia:
    """The inertia of bodies that are welded together, in the frame of what carries them."""

    mass: float = 0.0  # [kg]
    centre: Array = field(default_factory=lambda: np.zeros(3))  # of mass [m]
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

    def moved(self, kind: str, axis: Array, frame: Frame, place: Array) -> Frame:
        """Add a link that moves about or along an axis through a place, both of a frame; returns
        that frame as the link moves it."""
        turn = turned_to(axis)
        joint = frame.within(place, turn)
        self.parents.append(joint.carrier)
        self.kinds.append(kind)
        self.places.append(joint.place)
        self.turns.append(joint.turn)
        return Frame(len(self.parents) - 1, -turn.T @ place, turn.T)


def turned_to(axis: Array) -> Array:
    """A rotation, a matrix, that turns the z axis to an axis of unit length."""
    return np.asarray(Rotation.align_vectors(axis[None], AXES[2:])[0].as_matrix())


@dataclass(frozen=True)
class Bodies:
    """The bodies of a mechanism as Exudyn has them."""

    links: Links
    frames: tuple[Frame, ...]  # one a body
    inertias: Mapping[int, Inertia]  # {carrier: of all bodies that it carries}
    places: tuple[slice, ...]  # of the coordinates of each joint in those of the system


@dataclass(frozen=True)
class Built:
    """A mechanism in an Exudyn system."""

    container: Any
    system: Any
    nodes: tuple[int, ...]  # of the tree, if there is one, then of each free body by itself
    places: tuple[slice, ...]  # of the coordinates of each joint in those of the system
    alone: tuple[bool, ...]  # whether a joint is that of a free body by itself


def build(
    mechanism: Mechanism, controls: Controls | None, explicit: bool, duration: float
) -> Built:
    """The system of a mechanism whose actuators have controls of the time, or controls that stay
    zero, for runs of a `duration` [s] by an explicit solver or an implicit one; raises Unsupported.
    """
    for feature in refused(mechanism, explicit, duration):
        raise Unsupported(f"feature {feature}")
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    bodies = _bodies(mechanism)
    nodes = list[int]()
    carriers = {WORLD: system.AddObject(items.ObjectGround())}
    size = len(bodies.links.parents)
    if size:
        forces = joint_forces(mechanism, bodies.places, size, controls)
        node, tree = _tree(system, bodies, mechanism.gravity, forces)
        nodes.append(node)
        carriers |= dict.fromkeys(range(size), tree)
        _impose(mechanism, system, bodies, node, explicit, duration)
    for carrier in (carrier for carrier in bodies.inertias if carrier < WORLD):
        node, carriers[carrier] = _rigid(system, bodies.inertias[carrier], mechanism.gravity)
        nodes.append(node)
    for loop in mechanism.loops:
        _close(mechanism, system, bodies, carriers, loop)
    system.Assemble()
    alone = tuple(bodies.frames[joint.body].carrier < WORLD for joint in mechanism.joints)
    return Built(container, system, tuple(nodes), bodies.places, alone)


def refused(mechanism: Mechanism, explicit: bool, duration: float) -> Iterator[str]:
    """The names of features of a mechanism that Exudyn, its explicit solvers, or this builder
    cannot express."""
    yield from refused_parts(mechanism)
    yield from (f"carried weight of body {x.name}" for x in mechanism.bodies if x.carried)
    for joint in mechanism.joints:
        name = joint.name or f"of body {mechanism.bodies[joint.body].name}"
        if joint.limits or np.any(joint.friction_loss):
            yield f"limit or dry friction of joint {name}"
        acts = joint.stiffness or np.any(joint.damping) or np.any(joint.armature)
        if joint.kind in CHAINS and acts:
            yield f"spring, damper or armature of joint {name}, which is a {joint.kind} joint"
        if explicit and joint.velocity and not constant(joint.velocity, duration):
            yield f"changing velocity of joint {name}, which explicit solvers do not prescribe"
    if explicit:
        yield from (f"loop {x.name}, which explicit solvers leave open" for x in mechanism.loops)
    if mechanism.touching:
        yield "contacts"


def constant(velocity: Velocity, duration: float) -> bool:
    """Whether a velocity is the same throughout a `duration` [s]."""
    return bool(np.ptp(velocity(np.linspace(0.0, duration, 1001))) == 0.0)


def _bodies(mechanism: Mechanism) -> Bodies:
    """The bodies of a mechanism as Exudyn has them."""
    links, frames = Links(), [Frame()]
    inertias = defaultdict[int, Inertia](Inertia)
    places = dict[int, slice]()
    carrying = {mechanism.bodies[joint.body].parent for joint in mechanism.joints}
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        frame = frames[body.parent].within(body.place, rotation(body.attitude))
        for i, joint in enumerate(mechanism.joints):
            if joint.body != number:
                continue
            begin = len(links.parents)
            if joint.kind == "free":  # its coordinates are those of its frame in the world
                frame = Frame(WORLD if number in carrying else WORLD - number)
            if frame.carrier >= WORLD:
                for kind, axis in CHAINS.get(joint.kind, ((joint.kind, joint.axis),)):
                    frame = links.moved(kind, axis, frame, joint.place)
            places[i] = slice(begin, len(links.parents))
        frames.append(frame)
        moments = np.zeros((3, 3)) if body.point else frame.turn @ body.inertia @ frame.turn.T
        centre = frame.place + frame.turn @ body.centre
        inertias[frame.carrier] += Inertia(body.mass, centre, moments)
    first = len(links.parents)
    for i, joint in enumerate(mechanism.joints):
        if frames[joint.body].carrier < WORLD:
            places[i] = slice(first, first + 6)
            first += 6
    in_order = tuple(places[i] for i in range(len(mechanism.joints)))
    return Bodies(links, tuple(frames), inertias, in_order)


def _tree(
    system: Any, bodies: Bodies, gravity: Array, forces: Mapping[str, Any]
) -> tuple[int, int]:
    """Add the tree; returns the numbers of its node and of its object."""
    links = bodies.links
    size = len(links.parents)
    inertias = [bodies.inertias.get(link, Inertia()) for link in range(size)]
    node = system.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=[0.0] * size,
            initialCoordinates=[0.0] * size,
            initialCoordinates_t=[0.0] * size,
            numberOfODE2Coordinates=size,
        )
    )
    tree = items.ObjectKinematicTree(
        nodeNumber=node,
        gravity=gravity.tolist(),
        jointTypes=[TYPES[kind] for kind in links.kinds],
        linkParents=links.parents,
        jointTransformations=exudyn.Matrix3DList(links.turns),
        jointOffsets=exudyn.Vector3DList(links.places),
        linkInertiasCOM=exudyn.Matrix3DList([own.moments for own in inertias]),
        linkCOMs=exudyn.Vector3DList([own.centre for own in inertias]),
        linkMasses=[own.mass for own in inertias],
        **forces,
    )
    return node, system.AddObject(tree)


def _rigid(system: Any, inertia: Inertia, gravity: Array) -> tuple[int, int]:
    """Add a free body by itself; returns the numbers of its node and of its object. Its
    coordinates are its place and a rotation vector, on which solvers work as on a group."""
    node = system.AddNode(items.NodeRigidBodyRotVecLG(referenceCoordinates=[0.0] * 6))
    arm = inertia.centre
    about = inertia.moments + inertia.mass * (arm @ arm * AXES - np.outer(arm, arm))
    body = items.ObjectRigidBody(
        nodeNumber=node,
        mass=inertia.mass,
        centerOfMass=arm,
        inertia=[*np.diag(about), about[1, 2], about[0, 2], about[0, 1]],
    )
    number = system.AddObject(body)
    if np.any(gravity):
        marker = system.AddMarker(items.MarkerBodyMass(bodyNumber=number))
        weight = items.LoadMassProportional(markerNumber=marker, loadVector=gravity)
        system.AddLoad(weight)
    return node, number


def _impose(
    mechanism: Mechanism, system: Any, bodies: Bodies, node: int, explicit: bool, duration: float
) -> None:
    """Add the armatures of the joints of a tree, and what prescribes their velocities: a
    constraint for an implicit solver, a rotor for an explicit one, which has no constraints."""
    rotors = np.zeros(len(bodies.links.parents))
    for joint, place in zip(mechanism.joints, bodies.places, strict=True):
        if joint.kind in CHAINS:
            continue
        rotors[place] = joint.armature
        if joint.velocity is not None and explicit:
            rotors[place] = HOLDING * _largest_inertia(mechanism)
        elif joint.velocity is not None:
            _prescribe(system, node, place.start, joint.velocity, duration)
    if rotors.any():
        system.AddObject(items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=np.diag(rotors)))


def _largest_inertia(mechanism: Mechanism) -> float:
    """An inertia that is larger than any that a joint moves [kg m^2] or [kg], for lengths of up to
    a metre or those of the mechanism."""
    reach = sum(np.linalg.norm(body.place) + np.linalg.norm(body.centre) for body in mechanism.bodies)
    mass = sum(body.mass for body in mechanism.bodies)
    spread = sum(float(np.trace(body.inertia)) for body in mechanism.bodies)
    return float(mass * max(1.0, reach) ** 2 + spread)


def _prescribe(
    system: Any, node: int, coordinate: int, velocity: Velocity, duration: float
) -> None:
    """Constrain the velocity of a coordinate."""
    ground = system.AddNode(items.NodePointGround())
    markers = [
        system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=number, coordinate=which))
        for number, which in ((ground, 0), (node, coordinate))
    ]

    def at(system: Any, now: float, item: int, offset: float) -> float:
        return float(velocity(np.array([now]))[0])

    fixed = constant(velocity, duration)
    constraint = items.ObjectConnectorCoordinate(
        markerNumbers=markers,
        velocityLevel=True,
        offset=at(system, 0.0, 0, 0.0) if fixed else 0.0,
        offsetUserFunction_t=0 if fixed else at,
    )
    system.AddObject(constraint)


def _close(
    mechanism: Mechanism, system: Any, bodies: Bodies, carriers: Mapping[int, int], loop: Loop
) -> None:
    """Add the constraint that closes a loop. Where all motion is in a plane, points stay in it by
    themselves: a constraint across it, which would be singular, is left out."""
    turn, axes = AXES, [1, 1, 1, 0, 0, 0]
    if loop.kind == "weld":
        turn, axes = rotation(loop.attitude), [1] * 6
    elif (normal := _normal(mechanism, loop)) is not None:
        turn, axes = turned_to(normal), [1, 1, 0, 0, 0, 0]
    frames = [bodies.frames[number] for number in loop.bodies]
    first, second = (
        frame.within(place, own)
        for frame, place, own in zip(frames, loop.places, (turn, AXES), strict=True)
    )
    markers = [add_marker(system, carriers, frame) for frame in (first, second)]
    system.AddObject(items.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=axes))


def _normal(mechanism: Mechanism, loop: Loop) -> Array | None:
    """The normal, in the frame of the first body of a loop, of the plane in which all joints that
    move the bodies of the loop let them move; None where there is no such plane."""
    turns = [AXES]
    movers = [tuple[Joint, ...]()]
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        turns.append(turns[body.parent] @ rotation(body.attitude))
        own = tuple(joint for joint in mechanism.joints if joint.body == number)
        movers.append(movers[body.parent] + own)
    joints = [joint for number in loop.bodies for joint in movers[number]]
    axes = {kind: [turns[x.body] @ x.axis for x in joints if x.kind == kind] for kind in TYPES}
    if sum(map(len, axes.values())) < len(joints) or not axes["hinge"]:
        return None
    normal = axes["hinge"][0]
    across = [np.linalg.norm(np.cross(axis, normal)) for axis in axes["hinge"]]
    along = [abs(axis @ normal) for axis in axes["slide"]]
    return turns[loop.bodies[0]].T @ normal if max(across + along) < PARALLEL else None


def add_marker(system: Any, carriers: Mapping[int, int], frame: Frame) -> int:
    """Add a marker of a frame; returns its number."""
    at = np.eye(4)
    at[:3, :3], at[:3, 3] = frame.turn, frame.place
    number = carriers[frame.carrier]
    if frame.carrier <= WORLD:
        marker = items.MarkerBodyRigid(bodyNumber=number, localHT=at)
    else:
        marker = items.MarkerKinematicTreeRigid(
            objectNumber=number, linkNumber=frame.carrier, localHT=at
        )
    return int(system.AddMarker(marker))
