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
from plumbob.engines.adapters.refusals import (
    names_of,
    refused_friction,
    refused_parts,
    refused_shapes,
)
from plumbob.engines.mechanism import Body, Joint, Mechanism, Shape
from plumbob.engines.method import Options, Unsupported
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
OF_BODIES = ("linearDamping", "angularDamping", "maxJointVelocity")  # settings of multibodies
UNLIMITED = 1e12  # [N] or [N m] largest force of motors, limits and loops
FLAT = 1e-6  # largest thickness, relative to the radius, of an ellipsoid taken for a cylinder
EDGE = 1e-3  # radius of a cylinder's edge, relative to the smallest size of the cylinder
UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])
ORIGIN = np.zeros(3)
NO_INERTIA = np.zeros((3, 3))
BASE = -1  # number of a multibody's base among its links
NONE = -1  # stands for the world in place of the number of a tree
WELD = -1  # stands for the weld of a body to its parent in place of the number of a joint
At = tuple[int, int]
"""The number of a multibody, and the number of one of its links."""
Surface = tuple[int, float, float]
"""The number of a shape, and the coefficients of friction and of restitution of a copy of the
shape."""


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
    centre: Array = field(
        default_factory=lambda: ORIGIN
    )  # centre of mass in the link's frame [m]
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
class Placed:
    """The link that a body belongs to."""

    tree: int  # number of the tree, or NONE
    link: int  # number of the link in the tree
    origin: Array  # origin of the link's frame in the body's frame [m]


@dataclass(frozen=True)
class Built:
    """A mechanism in a PyBullet world."""

    client: Any
    joints: tuple[At, ...]  # link that each joint moves
    bodies: tuple[Placed, ...]  # link of each body; the first is the world, with the tree NONE
    inertial: Mapping[At, tuple[Array, Array]]
    """For each link its centre of mass [m], and the quaternion of its principal axes of inertia,
    scalar last, both in the link's frame."""


def build(client: Any, mechanism: Mechanism, settings: Options, step: float) -> Built:
    """Builds the world of a mechanism at a time step [s] in a client whose world is empty; raises
    Unsupported."""
    for feature in refused(mechanism):
        raise Unsupported(f"feature {feature}")
    _set_up_world(client, mechanism, settings, step)
    trees, bodies, joints = _trees(mechanism)
    pairs = list(_pairs(mechanism, trees, bodies))
    made = [_made(client, links, settings) for links in trees]
    _let_collide(client, made, pairs)
    moved = tuple((made[at[0]], at[1]) for at in joints)
    _set_up_joints(client, mechanism.joints, moved)
    homes = (bodies[0], *(replace(body, tree=made[body.tree]) for body in bodies[1:]))
    inertial = dict(_inertial(made, trees))
    _close_loops(client, mechanism, homes, inertial)
    return Built(client, moved, homes, inertial)


def _let_collide(client: Any, made: Sequence[int], pairs: Iterable[tuple[At, At]]) -> None:
    """Lets the pairs of links collide. `made` has the multibody of each tree."""
    for (one, here), (other, there) in pairs:
        client.setCollisionFilterPair(made[one], made[other], here, there, 1)


def _set_up_world(client: Any, mechanism: Mechanism, settings: Options, step: float) -> None:
    """Gives a world the gravity of a mechanism, a time step [s] and settings."""
    of_world = {name: value for name, value in settings.items() if name not in OF_BODIES}
    client.setGravity(*mechanism.gravity)
    client.setPhysicsEngineParameter(
        fixedTimeStep=step, deterministicOverlappingPairs=1, **of_world
    )


def _inertial(
    made: Sequence[int], trees: Sequence[Sequence[Link]]
) -> Iterator[tuple[At, tuple[Array, Array]]]:
    """Each link of the trees, with its centre of mass and the quaternion of its principal axes of
    inertia. `made` has the multibody of each tree."""
    for tree, links in zip(made, trees, strict=True):
        for number, link in enumerate(links, start=BASE):
            yield (tree, number), (link.centre, link.principal[1])


def refused(mechanism: Mechanism) -> Iterator[str]:
    """Names the features of a mechanism that PyBullet, or this builder, cannot express."""
    yield from refused_parts(mechanism)
    for joint in mechanism.joints:
        yield from _refused_of(joint, mechanism)
    yield from refused_shapes(mechanism)
    for shape in mechanism.shapes:
        if shape.kind == "ellipsoid" and not _is_disc(shape):
            yield f"ellipsoid {shape.name}, which is no flat disc"
    for touch in mechanism.touching:
        names = names_of(mechanism, touch)
        yield from refused_friction(touch, names)


def _refused_of(joint: Joint, mechanism: Mechanism) -> Iterator[str]:
    """Names the features of a joint that PyBullet, or this builder, cannot express."""
    name = joint.name or f"of body {mechanism.bodies[joint.body].name}"
    bound = joint.stiffness or joint.limits is not None or np.any(joint.friction_loss)
    if joint.kind in ("ball", "free") and bound:
        yield f"spring, limit or dry friction of joint {name}, which is a {joint.kind} joint"
    if joint.kind == "free" and np.any(joint.damping):
        yield f"damping of joint {name}, which is a free joint"
    alone = joint.kind == "hinge" and not _turned(joint, mechanism)
    if np.any(joint.armature) and not alone:
        yield f"armature of joint {name} that is no hinge, or that other joints turn"


def _turned(joint: Joint, mechanism: Mechanism) -> bool:
    """Whether joints other than a hinge itself turn the axis of the hinge."""
    carriers = {joint.body}
    for number in range(joint.body, 0, -1):
        if number in carriers:
            carriers.add(mechanism.bodies[number].parent)
    turning = [x for x in mechanism.joints if x.body in carriers and x.kind != "slide"]
    return turning[0] is not joint


def _is_disc(shape: Shape) -> bool:
    """Whether an ellipsoid is so flat that a cylinder can stand for it."""
    return bool(shape.size[0] == shape.size[1] and shape.size[2] <= FLAT * shape.size[0])


def _trees(mechanism: Mechanism) -> tuple[list[list[Link]], list[Placed], list[At]]:
    """The links of each tree, the base first; the link of each body, which for the world is of the
    tree NONE; and the link that each joint moves."""
    trees = list[list[Link]]()
    bodies = [Placed(NONE, BASE, ORIGIN)]
    joints = dict[int, At]()
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        own = [i for i, joint in enumerate(mechanism.joints) if joint.body == number]
        massive = Link(mass=body.mass, centre=body.centre, inertia=body.inertia)
        if own and mechanism.joints[own[0]].kind == "free":
            trees.append([massive])
            joints[own[0]] = (len(trees) - 1, BASE)
            bodies.append(Placed(len(trees) - 1, BASE, ORIGIN))
            continue
        above = bodies[body.parent]
        if body.parent == 0:
            trees.append([Link()])
            above = Placed(len(trees) - 1, BASE, ORIGIN)
        links = trees[above.tree]
        for i in own or [WELD]:
            links.append(_jointed(mechanism, i, body, above, i in (WELD, *own[:1])))
            above = Placed(above.tree, len(links) - 2, ORIGIN)
            if i != WELD:
                above = replace(above, origin=mechanism.joints[i].place)
                joints[i] = (above.tree, above.link)
        last = links[-1]
        links[-1] = replace(
            last,
            mass=body.mass,
            centre=body.centre - above.origin,
            inertia=last.inertia + body.inertia,
        )
        bodies.append(above)
    return trees, bodies, [joints[i] for i in range(len(mechanism.joints))]


def _jointed(mechanism: Mechanism, i: int, body: Body, above: Placed, first: bool) -> Link:
    """A link without mass that joint `i` moves or, if `i` is WELD, that is welded to the link
    `above`. If it is the `first` link of its body, its frame includes the place and the attitude of
    the body in the parent. An armature is a moment of inertia of the link about the axis."""
    if i == WELD:
        return Link("fixed", above.link, body.place - above.origin, body.attitude)
    joint = mechanism.joints[i]
    place, attitude = joint.place, UNTURNED
    if first:
        place, attitude = body.place + rotation(body.attitude) @ joint.place, body.attitude
    rotor = float(joint.armature[0]) * np.outer(joint.axis, joint.axis)
    return Link(
        joint.kind, above.link, place - above.origin, attitude, joint.axis, inertia=rotor
    )


def _pairs(
    mechanism: Mechanism, trees: list[list[Link]], bodies: list[Placed]
) -> Iterator[tuple[At, At]]:
    """The links of each pair of shapes that can touch. Adds a link for each shape to the tree of
    the shape's body; for a shape of the world it adds a tree.

    A link of Bullet has a factor of friction and a factor of restitution, and the coefficients of a
    pair of links are the products of their factors. If a shape has several coefficients, there is a
    copy of the shape for each."""
    made = dict[Surface, At]()
    for touch in mechanism.touching:
        surfaces = [(i, touch.sliding[0], touch.restitution) for i in touch.shapes]
        for i, friction, restitution in surfaces:
            if (i, friction, restitution) in made:
                continue
            shape = mechanism.shapes[i]
            body = bodies[shape.body]
            link = Link(
                parent=body.link,
                place=shape.place - body.origin,
                attitude=shape.attitude,
                shape=shape,
                surface=(math.sqrt(friction), math.sqrt(restitution)),
            )
            if body.tree == NONE:
                trees.append([link])
            else:
                trees[body.tree].append(link)
            tree = len(trees) - 1 if body.tree == NONE else body.tree
            made[i, friction, restitution] = (tree, len(trees[tree]) - 2)
        yield made[surfaces[0]], made[surfaces[1]]


def last_scalar(attitude: Array) -> list[float]:
    """The quaternion `attitude`, scalar first, with its scalar last."""
    rolled: list[float] = np.roll(attitude, -1).tolist()
    return rolled


def _made(client: Any, links: list[Link], settings: Options) -> int:
    """Adds the multibody of a tree of links, the base first; returns its number. No link collides
    with another yet."""
    base, *others = links
    shapes = [_shape(client, link.shape) for link in links]
    frames = [link.principal for link in links]
    collides = client.URDF_USE_SELF_COLLISION | client.URDF_USE_SELF_COLLISION_INCLUDE_PARENT
    tree: int = client.createMultiBody(
        # If the base has no mass from the beginning, Bullet also makes the links immovable that are
        # fixed to the base's first link. So the base gets a mass here, and loses it below.
        baseMass=base.mass or 1.0,
        baseCollisionShapeIndex=shapes[0],
        basePosition=base.place.tolist(),
        baseOrientation=last_scalar(base.attitude),
        baseInertialFramePosition=base.centre.tolist(),
        baseInertialFrameOrientation=frames[0][1].tolist(),
        linkMasses=[link.mass for link in others],
        linkCollisionShapeIndices=shapes[1:],
        linkVisualShapeIndices=[-1] * len(others),
        linkPositions=[link.place.tolist() for link in others],
        linkOrientations=[last_scalar(link.attitude) for link in others],
        linkInertialFramePositions=[link.centre.tolist() for link in others],
        linkInertialFrameOrientations=[axes.tolist() for _, axes in frames[1:]],
        # In this list Bullet numbers the base 0, and links from 1.
        linkParentIndices=[link.parent + 1 for link in others],
        linkJointTypes=[getattr(client, KINDS[link.kind]) for link in others],
        linkJointAxis=[link.axis.tolist() for link in others],
        flags=collides,
    )
    if not base.mass:
        client.changeDynamics(tree, BASE, mass=0.0)
    chosen = {name: settings[name] for name in OF_BODIES if name in settings}
    # This call resets the inertia of links, which is set below.
    client.changeDynamics(tree, BASE, **chosen)
    for number, (link, (moments, _)) in enumerate(zip(links, frames, strict=True), start=BASE):
        friction, restitution = link.surface
        client.setCollisionFilterGroupMask(tree, number, 0, 0)
        client.changeDynamics(
            tree,
            number,
            localInertiaDiagonal=moments.tolist(),
            lateralFriction=friction,
            restitution=restitution,
        )
    return tree


def _shape(client: Any, shape: Shape | None) -> int:
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
    made = client.createCollisionShape(
        client.GEOM_CYLINDER, radius=size[0], height=2.0 * size[-1]
    )
    # By default the edge of a cylinder is rounded within a margin of 1 mm, even if the cylinder is
    # thinner. The margin belongs to the shape, but can only be changed through a base that has the
    # shape.
    carrier = client.createMultiBody(0.0, made)
    client.setCollisionFilterGroupMask(carrier, BASE, 0, 0)
    client.changeDynamics(carrier, BASE, collisionMargin=EDGE * min(size))
    return int(made)


def _set_up_joints(client: Any, joints: Sequence[Joint], moved: Sequence[At]) -> None:
    """Gives joints their limits and their dry friction. Dry friction is a motor that stops a joint,
    limited to the force of friction. Setting that force to zero removes Bullet's default motor."""
    for joint, at in zip(joints, moved, strict=True):
        if joint.kind == "free":
            continue
        if joint.kind == "ball":
            start = {"targetPosition": [0, 0, 0, 1], "force": [0, 0, 0]}
            client.setJointMotorControlMultiDof(*at, client.POSITION_CONTROL, **start)
            continue
        loss = float(joint.friction_loss[0])
        client.setJointMotorControl2(*at, client.VELOCITY_CONTROL, force=loss)
        if joint.limits is not None:
            low, high = (limit - float(joint.reference[0]) for limit in joint.limits)
            limits = {"jointLowerLimit": low, "jointUpperLimit": high}
            client.changeDynamics(*at, **limits, jointLimitForce=UNLIMITED)


def _close_loops(
    client: Any,
    mechanism: Mechanism,
    homes: Sequence[Placed],
    inertial: Mapping[At, tuple[Array, Array]],
) -> None:
    """Adds constraints that close the loops of a mechanism. Bullet wants the frames of a constraint
    relative to the links' principal frames of inertia."""
    for loop in mechanism.loops:
        turns = (UNTURNED, UNTURNED) if loop.kind == "connect" else (loop.attitude, UNTURNED)
        frames = [
            _within(inertial, homes[body], place, turn)
            for body, place, turn in zip(loop.bodies, loop.places, turns, strict=True)
        ]
        ends = [(homes[i], *frame) for i, frame in zip(loop.bodies, frames, strict=True)]
        if ends[0][0].tree == NONE:  # only the second end of a constraint can be on the world
            ends.reverse()
        (first, place, turn), (second, other, turned) = ends
        kind = getattr(client, KINDS[loop.kind])
        made = client.createConstraint(
            *(first.tree, first.link, second.tree, second.link, kind, [0, 0, 0]),
            *(place, other, turn, turned),
        )
        client.changeConstraint(made, maxForce=UNLIMITED)


def _within(
    inertial: Mapping[At, tuple[Array, Array]], home: Placed, place: Array, attitude: Array
) -> tuple[list[float], list[float]]:
    """The place [m] and the quaternion, scalar last, of a frame in the principal frame of inertia
    of a body's link. `place` [m] and `attitude`, scalar first, give the frame in the body's
    frame."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_quat(attitude, scalar_first=True)
    if home.tree == NONE:
        return place.tolist(), turn.as_quat().tolist()
    centre, axes = inertial[home.tree, home.link]
    back = Rotation.from_quat(axes).inv()
    return back.apply(place - home.origin - centre).tolist(), (back * turn).as_quat().tolist()
