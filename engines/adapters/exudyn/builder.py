"""Builds the Exudyn system of a mechanism: its tree and its lone free bodies, the forces on joints
and their prescribed motions, constraints that close loops, and contacts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import exudyn
import exudyn.itemInterface
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.exudyn.bodies import (
    AXES,
    CHAINS,
    PARALLEL,
    WORLD,
    Bodies,
    Frame,
    Inertia,
    bodies_of,
    moving_joints,
    norm,
    turned_to,
)
from plumbob.engines.adapters.exudyn.contacts import Contacts, refused_contacts
from plumbob.engines.adapters.exudyn.motors import joint_forces
from plumbob.engines.adapters.exudyn.tables import Tabulated
from plumbob.engines.adapters.joints import joint_name
from plumbob.engines.adapters.reference_pose import reference_pose
from plumbob.engines.adapters.refusals import refuse, refused_parts, refused_weights
from plumbob.engines.mechanism import JointKind, Loop, Mechanism, Shape, is_constant
from plumbob.engines.peer_model import rotation
from plumbob.models.idealisations import Velocity

TYPES = MappingProxyType(
    {"hinge": exudyn.JointType.RevoluteZ, "slide": exudyn.JointType.PrismaticZ}
)

items = exudyn.itemInterface
# A rotor prescribes a constant velocity: its inertia [kg m^2], or its mass [kg], is this number
# times the mass of all bodies, so that no bit of its velocity changes.
HOLDING = 1e15


@dataclass(frozen=True)
class PlacedJoint:
    """A joint in an Exudyn system."""

    kind: JointKind
    place: slice  # place of its coordinates among Exudyn's
    lone_free: bool  # whether it is the joint of a lone free body


@dataclass(frozen=True)
class Built:
    """A mechanism in an Exudyn system."""

    container: Any
    system: Any
    nodes: tuple[int, ...]  # node of the tree if there is one, then the node of each free body
    joints: tuple[PlacedJoint, ...]


def build(
    mechanism: Mechanism,
    step: float,
    controls: Callable[[float], Sequence[float]] | None,
    *,
    explicit: bool,
) -> Built:
    """The system of a mechanism for runs at a time step [s]. `controls` returns the controls at
    a time [s]; None stands for controls that stay zero. `explicit` tells whether the solver is
    explicit. Raises Unsupported."""
    refuse(refused_features(mechanism, explicit))
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    bodies = bodies_of(mechanism)
    nodes = list[int]()
    carriers = {WORLD: system.AddObject(items.ObjectGround())}
    size = len(bodies.links.parents)
    if size:
        forces = joint_forces(mechanism, bodies.places, size, controls)
        node, tree = _add_tree(system, bodies, mechanism.gravity, forces)
        nodes.append(node)
        carriers |= dict.fromkeys(range(size), tree)
        _add_rotors(mechanism, system, bodies, node, explicit, step)
    for carrier, inertia in bodies.inertias.items():
        if carrier < WORLD:
            node, carriers[carrier] = _add_free_body(system, inertia, mechanism.gravity)
            nodes.append(node)
    for loop in mechanism.loops:
        _close_loop(mechanism, system, bodies, carriers, loop)
    _add_contacts(mechanism, system, bodies, carriers, step)
    system.Assemble()
    joints = tuple(
        PlacedJoint(joint.kind, place, bodies.frames[joint.body].carrier < WORLD)
        for joint, place in zip(mechanism.joints, bodies.places, strict=True)
    )
    return Built(container, system, tuple(nodes), joints)


def refused_features(mechanism: Mechanism, explicit: bool) -> Iterator[str]:
    """Names the features of a mechanism that Exudyn, or this builder, cannot express; if
    `explicit`, also the features that Exudyn's explicit solvers cannot express."""
    yield from refused_parts(mechanism)
    yield from refused_weights(mechanism)
    for joint in mechanism.joints:
        name = joint_name(mechanism, joint)
        if joint.limits or np.any(joint.friction_loss):
            yield f"limit or dry friction of joint {name}"
        acts = joint.stiffness or np.any(joint.damping) or np.any(joint.armature)
        if joint.kind in CHAINS and acts:
            yield f"spring, damper or armature of joint {name}, which is a {joint.kind} joint"
        if explicit and joint.velocity and not is_constant(joint.velocity):
            yield f"changing velocity of joint {name}, which explicit solvers do not prescribe"
    if explicit:
        yield from (
            f"loop {loop.name}, which explicit solvers leave open" for loop in mechanism.loops
        )
        if mechanism.touching:
            yield "contacts, which explicit solvers evaluate only at the start of a step"
    yield from refused_contacts(mechanism)


def _add_tree(
    system: Any, bodies: Bodies, gravity: Array, forces: Mapping[str, Any]
) -> tuple[int, int]:
    """Adds the kinematic tree with the `forces` on its joints; returns the numbers of its node and
    of its object."""
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
        linkInertiasCOM=exudyn.Matrix3DList([inertia.moments for inertia in inertias]),
        linkCOMs=exudyn.Vector3DList([inertia.centre for inertia in inertias]),
        linkMasses=[inertia.mass for inertia in inertias],
        **forces,
    )
    return node, system.AddObject(tree)


def _add_free_body(system: Any, inertia: Inertia, gravity: Array) -> tuple[int, int]:
    """Adds a lone free body; returns the numbers of its node and of its object. The coordinates are
    its place and a rotation vector, which Exudyn's solvers update as an element of a Lie group."""
    node = system.AddNode(items.NodeRigidBodyRotVecLG(referenceCoordinates=[0.0] * 6))
    arm = inertia.centre
    of_unit_mass = arm @ arm * AXES - np.outer(arm, arm)
    moments = inertia.moments + inertia.mass * of_unit_mass  # about the origin of the frame
    body = items.ObjectRigidBody(
        nodeNumber=node,
        mass=inertia.mass,
        centerOfMass=arm,
        inertia=[*np.diag(moments), moments[1, 2], moments[0, 2], moments[0, 1]],
    )
    number = system.AddObject(body)
    if np.any(gravity):
        marker = system.AddMarker(items.MarkerBodyMass(bodyNumber=number))
        weight = items.LoadMassProportional(markerNumber=marker, loadVector=gravity)
        system.AddLoad(weight)
    return node, number


def _add_rotors(
    mechanism: Mechanism,
    system: Any,
    bodies: Bodies,
    node: int,
    explicit: bool,
    step: float,
) -> None:
    """Adds the armatures of the joints of a tree, and prescribes velocities. For an implicit solver
    a velocity is prescribed by a constraint. Explicit solvers have no constraints: for them it is
    prescribed by a rotor with so large an inertia that the velocity does not change."""
    rotors = np.zeros(len(bodies.links.parents))
    for joint, place in zip(mechanism.joints, bodies.places, strict=True):
        if joint.kind in CHAINS:  # a free or a ball joint: its armature is refused
            continue
        rotors[place] = joint.armature
        if joint.velocity is not None and explicit:
            rotors[place] = HOLDING * sum(body.mass for body in mechanism.bodies)
        elif joint.velocity is not None:
            _prescribe(system, node, place.start, joint.velocity, step)
    if rotors.any():
        system.AddObject(
            items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=np.diag(rotors))
        )


def _prescribe(
    system: Any, node: int, coordinate: int, velocity: Velocity, step: float
) -> None:
    """Adds a constraint that prescribes the velocity of a coordinate. The solver evaluates the
    velocity at the ends of steps."""
    ground = system.AddNode(items.NodePointGround())
    markers = [
        system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=number, coordinate=index))
        for number, index in ((ground, 0), (node, coordinate))
    ]
    table = Tabulated(velocity, step)

    def velocity_at(system: Any, now: float, item: int, offset: float) -> float:
        """The velocity at a time [s]. Exudyn's other arguments have no effect."""
        return float(table(now))

    constant = is_constant(velocity)
    constraint = items.ObjectConnectorCoordinate(
        markerNumbers=markers,
        velocityLevel=True,
        offset=float(table(0.0)) if constant else 0.0,
        offsetUserFunction_t=0 if constant else velocity_at,
    )
    system.AddObject(constraint)


def _close_loop(
    mechanism: Mechanism, system: Any, bodies: Bodies, carriers: Mapping[int, int], loop: Loop
) -> None:
    """Adds the constraint that closes a loop. If the bodies of the loop move in a plane, their
    points stay in the plane without a constraint: the constraint along the normal would be
    singular, and is left out."""
    turn = AXES
    axes = [1, 1, 1, 0, 0, 0]
    normal = _normal_of_loop(mechanism, loop)
    if loop.kind == "weld":
        turn = rotation(loop.attitude)
        axes = [1] * 6
    elif normal is not None:
        turn = turned_to(normal)
        axes = [1, 1, 0, 0, 0, 0]
    first, second = (bodies.frames[number] for number in loop.bodies)
    place, other_place = loop.places
    frames = (first.within(place, turn), second.within(other_place, AXES))
    markers = [add_marker(system, carriers, frame) for frame in frames]
    system.AddObject(items.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=axes))


def _add_contacts(
    mechanism: Mechanism, system: Any, bodies: Bodies, carriers: Mapping[int, int], step: float
) -> None:
    """Adds the contacts of all pairs of shapes that can touch."""

    def mark(shape: Shape, place: Array) -> int:
        """Adds a marker at a place in the frame of a shape; returns its number."""
        frame = bodies.frames[shape.body].within(shape.place, rotation(shape.attitude))
        return add_marker(system, carriers, frame.within(place, AXES))

    contacts = Contacts(system, mechanism, step, mark)
    for touch in mechanism.touching:
        contacts.add(touch)


def _normal_of_loop(mechanism: Mechanism, loop: Loop) -> Array | None:
    """The normal of the plane in which the two bodies of a loop move, in the frame of the first
    body. None if there is no such plane: it takes at least one hinge, all hinges parallel to the
    normal, and all slides in the plane."""
    pose = reference_pose(mechanism)
    first, second = loop.bodies
    joints = moving_joints(mechanism, first) + moving_joints(mechanism, second)
    if any(joint.kind not in TYPES for joint in joints):
        return None
    hinges = [pose.axis(joint) for joint in joints if joint.kind == "hinge"]
    slides = [pose.axis(joint) for joint in joints if joint.kind == "slide"]
    if not hinges:
        return None
    normal = hinges[0]
    misalignments = [norm(np.cross(axis, normal)) for axis in hinges]
    out_of_plane = [abs(float(axis @ normal)) for axis in slides]
    in_plane = max(misalignments + out_of_plane) < PARALLEL
    return pose.turns[first].T @ normal if in_plane else None


def add_marker(system: Any, carriers: Mapping[int, int], frame: Frame) -> int:
    """Adds a marker at a frame; returns the number of the marker."""
    pose = np.eye(4)
    pose[:3, :3] = frame.turn
    pose[:3, 3] = frame.place
    number = carriers[frame.carrier]
    if frame.carrier <= WORLD:
        marker = items.MarkerBodyRigid(bodyNumber=number, localHT=pose)
    else:
        marker = items.MarkerKinematicTreeRigid(
            objectNumber=number, linkNumber=frame.carrier, localHT=pose
        )
    return int(system.AddMarker(marker))
