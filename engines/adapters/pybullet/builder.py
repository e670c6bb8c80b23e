"""Builds the PyBullet world of a mechanism: a multibody for each tree of bodies, and one for each
shape of the world.

A joint of Bullet moves one link. If a body has several joints, the last joint moves the link with
the mass of the body, and each joint before it moves a link without mass. Each shape is on a
separate link without mass, which is fixed to the link of the body.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.joints import TURNING, joint_name, joints_of_body
from plumbob.engines.adapters.pybullet.client import BASE
from plumbob.engines.adapters.refusals import (
    names_of,
    refuse,
    refused_friction,
    refused_parts,
    refused_shapes,
)
from plumbob.engines.adapters.shape_copies import add_shape_copies
from plumbob.engines.mechanism import Body, Joint, Mechanism, Shape, Touch
from plumbob.engines.method import Options
from plumbob.engines.peer_model import rotation

KINDS = MappingProxyType(
    {
        "hinge": "JOINT_REVOLUTE",
        "slide": "JOINT_PRISMATIC",
        "ball": "JOINT_SPHERICAL",
        "fixed": "JOINT_FIXED",
        "connect": "JOINT_POINT2POINT",
        "weld": "JOINT_FIXED",
    }
)
# Settings that Bullet has for each multibody. All other settings of a method are the world's.
BODY_SETTINGS = ("linearDamping", "angularDamping", "maxJointVelocity")
UNLIMITED = 1e12  # [N] or [N m] largest force of motors, limits and loops
FLAT = 1e-6  # largest thickness, relative to the radius, of an ellipsoid taken for a cylinder
EDGE = 1e-3  # radius of a cylinder's edge, relative to the smallest size of the cylinder
UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])
ORIGIN = np.zeros(3)
NO_INERTIA = np.zeros((3, 3))
NONE = -1  # number in place of a tree's number that means the world

LinkKey = tuple[int, int]
"""The number of a multibody, and the number of one of its links."""
Surface = tuple[float, float]
"""The coefficients of friction and of restitution of a pair of shapes."""


@dataclass(frozen=True)
class Link:
    """A link of a multibody. Bullet has its inertia along principal axes about its centre of
    mass."""

    kind: str = "fixed"  # kind of the joint that moves it
    parent: int = BASE  # number of the link that carries it
    place: Array = field(default_factory=lambda: ORIGIN)  # in the parent link's frame [m]
    attitude: Array = field(default_factory=lambda: UNTURNED)  # in that frame, scalar first
    axis: Array = field(default_factory=lambda: ORIGIN)  # axis of the joint in the link's frame
    mass: float = 0.0  # [kg]
    centre: Array = field(default_factory=lambda: ORIGIN)
    """The centre of mass in the link's frame [m]."""
    inertia: Array = field(default_factory=lambda: NO_INERTIA)  # about the centre [kg m^2]
    shape: Shape | None = None
    surface: tuple[float, float] = (0.0, 0.0)
    """The factors of friction and of restitution: Bullet multiplies those of two links."""

    @property
    def principal(self) -> tuple[Array, Array]:
        """The principal moments of inertia [kg m^2], and the quaternion of the principal axes,
        scalar last."""
        from scipy.spatial.transform import Rotation

        moments, axes = np.linalg.eigh(self.inertia)
        axes[:, 2] *= np.linalg.det(axes)  # makes the axes right-handed
        return moments, Rotation.from_matrix(axes).as_quat()


@dataclass(frozen=True)
class BodyLink:
    """The link that a body belongs to."""

    tree: int  # number of the tree, or NONE
    link: int  # number of the link in the tree
    origin: Array  # origin of the link's frame in the body's frame [m]


@dataclass(frozen=True)
class Built:
    """A mechanism in a PyBullet world."""

    client: Any
    joints: tuple[LinkKey, ...]  # link that each joint moves
    bodies: tuple[BodyLink, ...]  # link of each body; the world has the tree NONE
    inertial: Mapping[LinkKey, tuple[Array, Array]]
    """For each link its centre of mass [m], and the quaternion of its principal axes of inertia,
    scalar last, both in the link's frame."""


def build(client: Any, mechanism: Mechanism, settings: Options, step: float) -> Built:
    """Builds the world of a mechanism at a time step [s] in a client whose world is empty; raises
    Unsupported."""
    refuse(refused_features(mechanism))
    _set_up_world(client, mechanism, settings, step)
    trees, bodies, joints = _trees(mechanism)
    pairs = _add_shape_links(mechanism, trees, bodies)
    multibodies = [_add_multibody(client, links, settings) for links in trees]
    _let_collide(client, multibodies, pairs)
    moved_links = tuple((multibodies[tree], link) for tree, link in joints)
    _set_up_joints(client, mechanism.joints, moved_links)
    moving = [replace(body, tree=multibodies[body.tree]) for body in bodies[1:]]
    body_links = (bodies[0], *moving)
    inertial = dict(_inertial_frames(multibodies, trees))
    _close_loops(client, mechanism, body_links, inertial)
    return Built(client, moved_links, body_links, inertial)


def _let_collide(
    client: Any, multibodies: Sequence[int], pairs: Iterable[tuple[LinkKey, LinkKey]]
) -> None:
    """Lets the pairs of links collide. `multibodies` has the multibody of each tree."""
    for (tree, link), (other_tree, other_link) in pairs:
        client.setCollisionFilterPair(
            multibodies[tree], multibodies[other_tree], link, other_link, 1
        )


def _set_up_world(client: Any, mechanism: Mechanism, settings: Options, step: float) -> None:
    """Gives a world the gravity of a mechanism, a time step [s] and settings."""
    world_settings = {
        name: value for name, value in settings.items() if name not in BODY_SETTINGS
    }
    client.setGravity(*mechanism.gravity)
    client.setPhysicsEngineParameter(
        fixedTimeStep=step, deterministicOverlappingPairs=1, **world_settings
    )


def _inertial_frames(
    multibodies: Sequence[int], trees: Sequence[Sequence[Link]]
) -> Iterator[tuple[LinkKey, tuple[Array, Array]]]:
    """Each link of the trees, with its centre of mass and the quaternion of its principal axes of
    inertia. `multibodies` has the multibody of each tree."""
    for multibody, links in zip(multibodies, trees, strict=True):
        for number, link in enumerate(links, start=BASE):
            _, axes = link.principal
            yield (multibody, number), (link.centre, axes)


def refused_features(mechanism: Mechanism) -> Iterator[str]:
    """Names the features of a mechanism that PyBullet, or this builder, cannot express."""
    yield from refused_parts(mechanism)
    for joint in mechanism.joints:
        yield from _refused_features_of_joint(joint, mechanism)
    yield from refused_shapes(mechanism)
    for shape in mechanism.shapes:
        if shape.kind == "ellipsoid" and not _is_disc(shape):
            yield f"ellipsoid {shape.name}, which is no flat disc"
    for touch in mechanism.touching:
        names = names_of(mechanism, touch)
        yield from refused_friction(touch, names)


def _refused_features_of_joint(joint: Joint, mechanism: Mechanism) -> Iterator[str]:
    """Names the features of a joint that PyBullet, or this builder, cannot express."""
    name = joint_name(mechanism, joint)
    bound = joint.stiffness or joint.limits is not None or np.any(joint.friction_loss)
    if joint.kind in TURNING and bound:
        yield f"spring, limit or dry friction of joint {name}, which is a {joint.kind} joint"
    if joint.kind == "free" and np.any(joint.damping):
        yield f"damping of joint {name}, which is a free joint"
    turns_alone = joint.kind == "hinge" and not _is_turned(joint, mechanism)
    if np.any(joint.armature) and not turns_alone:
        yield f"armature of joint {name}, which is no hinge or is turned by other joints"


def _is_turned(joint: Joint, mechanism: Mechanism) -> bool:
    """Whether joints other than a hinge itself turn the axis of the hinge."""
    carriers = {joint.body}
    for number in range(joint.body, 0, -1):
        if number in carriers:
            carriers.add(mechanism.bodies[number].parent)
    first_turning = next(
        other for other in mechanism.joints if other.body in carriers and other.kind != "slide"
    )
    return first_turning is not joint


def _is_disc(shape: Shape) -> bool:
    """Whether an ellipsoid is so flat that a cylinder can stand for it."""
    return bool(shape.size[0] == shape.size[1] and shape.size[2] <= FLAT * shape.size[0])


def _trees(mechanism: Mechanism) -> tuple[list[list[Link]], list[BodyLink], list[LinkKey]]:
    """The links of each tree, the base first; the link of each body, which for the world is of the
    tree NONE; and the link that each joint moves."""
    trees = list[list[Link]]()
    bodies = [BodyLink(NONE, BASE, ORIGIN)]
    joints = dict[int, LinkKey]()
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        joint_numbers = joints_of_body(mechanism, number)
        if joint_numbers and mechanism.joints[joint_numbers[0]].kind == "free":
            trees.append([Link(mass=body.mass, centre=body.centre, inertia=body.inertia)])
            joints[joint_numbers[0]] = (len(trees) - 1, BASE)
            bodies.append(BodyLink(len(trees) - 1, BASE, ORIGIN))
            continue
        body_link = bodies[body.parent]
        if body.parent == 0:
            trees.append([Link()])
            body_link = BodyLink(len(trees) - 1, BASE, ORIGIN)
        links = trees[body_link.tree]
        if not joint_numbers:
            links.append(_welded_link(body, body_link))
            body_link = BodyLink(body_link.tree, len(links) - 2, ORIGIN)
        for joint_number in joint_numbers:
            joint = mechanism.joints[joint_number]
            first = joint_number == joint_numbers[0]
            links.append(_moved_link(joint, body, body_link, first=first))
            body_link = BodyLink(body_link.tree, len(links) - 2, joint.place)
            joints[joint_number] = (body_link.tree, body_link.link)
        links[-1] = _with_body(links[-1], body, body_link)
        bodies.append(body_link)
    return trees, bodies, [joints[number] for number in sorted(joints)]


def _with_body(link: Link, body: Body, body_link: BodyLink) -> Link:
    """A link with the mass and the inertia of its body."""
    return replace(
        link,
        mass=body.mass,
        centre=body.centre - body_link.origin,
        inertia=link.inertia + body.inertia,
    )


def _welded_link(body: Body, above: BodyLink) -> Link:
    """A link without mass that is welded to the link `above`, at the place of a body."""
    return Link("fixed", above.link, body.place - above.origin, body.attitude)


def _moved_link(joint: Joint, body: Body, above: BodyLink, *, first: bool) -> Link:
    """A link without mass that a joint of a body moves, behind the link `above`. If it is the
    `first` link of the body, its frame includes the place and the attitude of the body in the
    parent. An armature is a moment of inertia of the link about the axis."""
    place = joint.place
    attitude = UNTURNED
    if first:
        place = body.place + rotation(body.attitude) @ joint.place
        attitude = body.attitude
    return Link(
        kind=joint.kind,
        parent=above.link,
        place=place - above.origin,
        attitude=attitude,
        axis=joint.axis,
        inertia=float(joint.armature[0]) * np.outer(joint.axis, joint.axis),
    )


def _add_shape_links(
    mechanism: Mechanism, trees: list[list[Link]], bodies: list[BodyLink]
) -> list[tuple[LinkKey, LinkKey]]:
    """Adds a link for each copy of a shape to the tree of the shape's body, or for a shape of the
    world as a new tree. Returns the links of each pair of shapes that can touch."""

    def add(number: int, surface: Surface) -> LinkKey:
        """Adds a link for the shape with a number and these coefficients."""
        shape = mechanism.shapes[number]
        return _add_shape_link(trees, bodies[shape.body], shape, surface)

    return add_shape_copies(mechanism, _surface, add)


def _surface(touch: Touch) -> Surface:
    """The coefficients of a pair of shapes."""
    return touch.sliding[0], touch.restitution


def _add_shape_link(
    trees: list[list[Link]], body: BodyLink, shape: Shape, surface: Surface
) -> LinkKey:
    """Adds a link for a copy of a shape to the tree of its body or, for a shape of the world, as a
    new tree; returns the numbers of the tree and of the link. The coefficients of a pair of links
    are the products of the links' factors: the factors of both are the square roots."""
    friction, restitution = surface
    link = Link(
        parent=body.link,
        place=shape.place - body.origin,
        attitude=shape.attitude,
        shape=shape,
        surface=(math.sqrt(friction), math.sqrt(restitution)),
    )
    tree = body.tree
    if tree == NONE:
        tree = len(trees)
        trees.append([])
    trees[tree].append(link)
    return tree, len(trees[tree]) - 2


def last_scalar(attitude: Array) -> list[float]:
    """The quaternion `attitude`, scalar first, with its scalar last."""
    quaternion: list[float] = np.roll(attitude, -1).tolist()
    return quaternion


def _add_multibody(client: Any, links: list[Link], settings: Options) -> int:
    """Adds the multibody of a tree of links, the base first; returns its number. No link collides
    with another yet."""
    base, *others = links
    shapes = [_add_collision_shape(client, link.shape) for link in links]
    moments, axes = zip(*(link.principal for link in links), strict=True)
    multibody: int = client.createMultiBody(
        # If the base has no mass from the beginning, Bullet also makes the links immovable that are
        # fixed to the base's first link. So the base gets a mass here, and loses it below.
        baseMass=base.mass or 1.0,
        baseCollisionShapeIndex=shapes[0],
        basePosition=base.place.tolist(),
        baseOrientation=last_scalar(base.attitude),
        baseInertialFramePosition=base.centre.tolist(),
        baseInertialFrameOrientation=axes[0].tolist(),
        linkMasses=[link.mass for link in others],
        linkCollisionShapeIndices=shapes[1:],
        linkVisualShapeIndices=[-1] * len(others),
        linkPositions=[link.place.tolist() for link in others],
        linkOrientations=[last_scalar(link.attitude) for link in others],
        linkInertialFramePositions=[link.centre.tolist() for link in others],
        linkInertialFrameOrientations=[quaternion.tolist() for quaternion in axes[1:]],
        # In this list Bullet numbers the base 0, and links from 1.
        linkParentIndices=[link.parent + 1 for link in others],
        linkJointTypes=[getattr(client, KINDS[link.kind]) for link in others],
        linkJointAxis=[link.axis.tolist() for link in others],
        flags=(client.URDF_USE_SELF_COLLISION | client.URDF_USE_SELF_COLLISION_INCLUDE_PARENT),
    )
    if not base.mass:
        client.changeDynamics(multibody, BASE, mass=0.0)
    settings_of_body = {name: settings[name] for name in BODY_SETTINGS if name in settings}
    # This call resets the inertia of links, which is set below.
    client.changeDynamics(multibody, BASE, **settings_of_body)
    for number, (link, inertia) in enumerate(zip(links, moments, strict=True), start=BASE):
        friction, restitution = link.surface
        client.setCollisionFilterGroupMask(multibody, number, 0, 0)
        client.changeDynamics(
            multibody,
            number,
            localInertiaDiagonal=inertia.tolist(),
            lateralFriction=friction,
            restitution=restitution,
        )
    return multibody


def _add_collision_shape(client: Any, shape: Shape | None) -> int:
    """Adds a collision shape to Bullet; returns its number, or -1 if `shape` is None."""
    if shape is None:
        return -1
    size = shape.size.tolist()
    match shape.kind:
        case "plane":
            return int(client.createCollisionShape(client.GEOM_PLANE))
        case "sphere":
            return int(client.createCollisionShape(client.GEOM_SPHERE, radius=size[0]))
        case "box":
            return int(client.createCollisionShape(client.GEOM_BOX, halfExtents=size))
        case "capsule":
            length = 2.0 * size[1]
            return int(
                client.createCollisionShape(client.GEOM_CAPSULE, radius=size[0], height=length)
            )
    cylinder = client.createCollisionShape(
        client.GEOM_CYLINDER, radius=size[0], height=2.0 * size[-1]
    )
    # By default the edge of a cylinder is rounded within a margin of 1 mm, even if the cylinder is
    # thinner. The margin belongs to the shape, but can only be changed through a base that has the
    # shape.
    carrier = client.createMultiBody(0.0, cylinder)
    client.setCollisionFilterGroupMask(carrier, BASE, 0, 0)
    client.changeDynamics(carrier, BASE, collisionMargin=EDGE * min(size))
    return int(cylinder)


def _set_up_joints(client: Any, joints: Sequence[Joint], links: Sequence[LinkKey]) -> None:
    """Gives joints their limits and their dry friction. Dry friction is a motor that stops a joint,
    limited to the force of friction. Setting that force to zero removes Bullet's default motor.
    `links` has the link that each joint moves."""
    for joint, link in zip(joints, links, strict=True):
        if joint.kind == "free":
            continue
        if joint.kind == "ball":
            no_motor = {"targetPosition": [0, 0, 0, 1], "force": [0, 0, 0]}
            client.setJointMotorControlMultiDof(*link, client.POSITION_CONTROL, **no_motor)
            continue
        friction = float(joint.friction_loss[0])
        client.setJointMotorControl2(*link, client.VELOCITY_CONTROL, force=friction)
        if joint.limits is not None:
            low, high = (limit - float(joint.reference[0]) for limit in joint.limits)
            limits = {"jointLowerLimit": low, "jointUpperLimit": high}
            client.changeDynamics(*link, **limits, jointLimitForce=UNLIMITED)


def _close_loops(
    client: Any,
    mechanism: Mechanism,
    body_links: Sequence[BodyLink],
    inertial: Mapping[LinkKey, tuple[Array, Array]],
) -> None:
    """Adds constraints that close the loops of a mechanism. Bullet wants the frames of a constraint
    relative to the links' principal frames of inertia."""
    for loop in mechanism.loops:
        body_link, other_body_link = (body_links[body] for body in loop.bodies)
        place, other_place = loop.places
        attitude = UNTURNED if loop.kind == "connect" else loop.attitude
        frame = _frame_in_link(inertial, body_link, place, attitude)
        other_frame = _frame_in_link(inertial, other_body_link, other_place, UNTURNED)
        if body_link.tree == NONE:  # only the second end of a constraint can be on the world
            body_link, other_body_link = other_body_link, body_link
            frame, other_frame = other_frame, frame
        constraint = client.createConstraint(
            parentBodyUniqueId=body_link.tree,
            parentLinkIndex=body_link.link,
            childBodyUniqueId=other_body_link.tree,
            childLinkIndex=other_body_link.link,
            jointType=getattr(client, KINDS[loop.kind]),
            jointAxis=[0, 0, 0],
            parentFramePosition=frame[0],
            childFramePosition=other_frame[0],
            parentFrameOrientation=frame[1],
            childFrameOrientation=other_frame[1],
        )
        client.changeConstraint(constraint, maxForce=UNLIMITED)


def _frame_in_link(
    inertial: Mapping[LinkKey, tuple[Array, Array]],
    body_link: BodyLink,
    place: Array,
    attitude: Array,
) -> tuple[list[float], list[float]]:
    """The place [m] and the quaternion, scalar last, of a frame in the principal frame of inertia
    of a body's link. `place` [m] and `attitude`, scalar first, give the frame in the body's
    frame."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_quat(attitude, scalar_first=True)
    if body_link.tree == NONE:
        return place.tolist(), turn.as_quat().tolist()
    centre, axes = inertial[body_link.tree, body_link.link]
    to_axes = Rotation.from_quat(axes).inv()
    place_in_axes = to_axes.apply(place - body_link.origin - centre)
    return place_in_axes.tolist(), (to_axes * turn).as_quat().tolist()
