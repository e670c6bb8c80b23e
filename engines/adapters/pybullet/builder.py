"""The PyBullet world of a mechanism: a multibody for each tree of bodies, and one for each shape of
the world.

A joint of Bullet moves one link. Of a body with several joints the last one moves the link with the
body's mass, and each joint before it moves a link without mass. Each shape is on a link of its own
without mass, which is fixed to the body's link.
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
OF_BODIES = ("linearDamping", "angularDamping", "maxJointVelocity")  # settings
UNLIMITED = 1e12  # [N] or [N m] of motors, limits and loops
FLAT = 1e-6  # the thickness over the radius up to which an ellipsoid is taken for a cylinder
EDGE = 1e-3  # radius of a cylinder's edge over its smallest size
UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])
ORIGIN = np.zeros(3)
NO_INERTIA = np.zeros((3, 3))
BASE = -1  # the number of a multibody's base among its links
NONE = -1  # stands for the world where a tree's number is: Bullet does not number the world
WELD = -1  # stands where a joint's number is, for a body that is welded to its parent
At = tuple[int, int]
"""A multibody, and the number of one of its links."""
Surface = tuple[int, float, float]
"""A shape, and the coefficients of friction and of restitution of a copy of it."""


@dataclass(frozen=True)
class Link:
    """A link of a multibody. Bullet has its inertia along principal axes about its centre."""

    kind: str = "fixed"  # of the joint that moves it
    parent: int = BASE
    place: Array = field(default_factory=lambda: ORIGIN)  # in the parent link's frame [m]
    attitude: Array = field(default_factory=lambda: UNTURNED)  # in that frame, scalar first
    axis: Array = field(default_factory=lambda: ORIGIN)
    mass: float = 0.0  # [kg]
    centre: Array = field(default_factory=lambda: ORIGIN)  # in its frame [m]
    inertia: Array = field(default_factory=lambda: NO_INERTIA)  # about its centre [kg m^2]
    shape: Shape | None = None
    surface: tuple[float, float] = (0.0, 0.0)  # its factors of friction and of restitution

    @property
    def principal(self) -> tuple[Array, Array]:
        """Principal moments [kg m^2], and the quaternion, scalar last, of their axes."""
        from scipy.spatial.transform import Rotation

        moments, axes = np.linalg.eigh(self.inertia)
        axes[:, 2] *= np.linalg.det(axes)  # right-handed
        return moments, Rotation.from_matrix(axes).as_quat()


@dataclass(frozen=True)
class Placed:
    """The link of a body: its tree, its number there, and the place of the link's frame in the
    body's frame [m]."""

    tree: int
    link: int
    origin: Array


@dataclass(frozen=True)
class Built:
    """A mechanism in a PyBullet world."""

    client: Any
    joints: tuple[At, ...]  # the link that each joint moves
    bodies: tuple[Placed, ...]  # the link of each body; of the world one of no multibody
    inertial: Mapping[At, tuple[Array, Array]]
    """The place [m] and the axes, a quaternion, scalar last, of each link's inertia in the link's
    frame."""


def build(client: Any, mechanism: Mechanism, settings: Options, step: float) -> Built:
    """The world of a mechanism at a time step [s], in a client without anything; raises
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
    """Let the links of these pairs collide, by the numbers of their trees."""
    for (one, here), (other, there) in pairs:
        client.setCollisionFilterPair(made[one], made[other], here, there, 1)


def _set_up_world(client: Any, mechanism: Mechanism, settings: Options, step: float) -> None:
    """Give a world its gravity, its time step [s] and its settings."""
    of_world = {name: value for name, value in settings.items() if name not in OF_BODIES}
    client.setGravity(*mechanism.gravity)
    client.setPhysicsEngineParameter(
        fixedTimeStep=step, deterministicOverlappingPairs=1, **of_world
    )


def _inertial(
    made: Sequence[int], trees: Sequence[Sequence[Link]]
) -> Iterator[tuple[At, tuple[Array, Array]]]:
    """Each link of the trees that were made, with the frame of its inertia."""
    for tree, links in zip(made, trees, strict=True):
        for number, link in enumerate(links, start=BASE):
            yield (tree, number), (link.centre, link.principal[1])


def refused(mechanism: Mechanism) -> Iterator[str]:
    """The names of features of a mechanism that PyBullet, or this builder, cannot express."""
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
    """The names of features of a joint that are not expressed."""
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
    """Whether other joints turn the axis of a hinge."""
    carriers = {joint.body}
    for number in range(joint.body, 0, -1):
        if number in carriers:
            carriers.add(mechanism.bodies[number].parent)
    turning = [x for x in mechanism.joints if x.body in carriers and x.kind != "slide"]
    return turning[0] is not joint


def _is_disc(shape: Shape) -> bool:
    """Whether an ellipsoid is so flat that a cylinder has its shape."""
    return bool(shape.size[0] == shape.size[1] and shape.size[2] <= FLAT * shape.size[0])


def _trees(mechanism: Mechanism) -> tuple[list[list[Link]], list[Placed], list[At]]:
    """The links of each tree, its base first; the link of each body, for the world one of no tree;
    and the tree and the number of the link that each joint moves."""
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
    """A link without a mass that joint `i` moves, or that is welded; the first one of a body also
    has the body's place in its parent. An armature is a moment of inertia about the axis."""
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
    """The links of each pair of shapes that can touch. Adds to the trees a link for each shape, and
    trees for those of the world.

    A link of Bullet has one coefficient of friction and one of restitution, and a pair has the
    products of two. A shape with several has a copy for each."""
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
    """A quaternion as Bullet has it, scalar last."""
    rolled: list[float] = np.roll(attitude, -1).tolist()
    return rolled


def _made(client: Any, links: list[Link], settings: Options) -> int:
    """The multibody of links, the base first, of which none collides yet."""
    base, *others = links
    shapes = [_shape(client, link.shape) for link in links]
    frames = [link.principal for link in links]
    collides = client.URDF_USE_SELF_COLLISION | client.URDF_USE_SELF_COLLISION_INCLUDE_PARENT
    tree: int = client.createMultiBody(
        # On a base that is made immovable, Bullet takes what is fixed to its first link, too, for
        # immovable: such a base gets a mass, which it loses below.
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
        # Bullet numbers a base 0 here, and links from 1.
        linkParentIndices=[link.parent + 1 for link in others],
        linkJointTypes=[getattr(client, KINDS[link.kind]) for link in others],
        linkJointAxis=[link.axis.tolist() for link in others],
        flags=collides,
    )
    if not base.mass:
        client.changeDynamics(tree, BASE, mass=0.0)
    chosen = {name: settings[name] for name in OF_BODIES if name in settings}
    client.changeDynamics(tree, BASE, **chosen)  # resets inertia, which is set below
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
    """The number of a shape of Bullet; -1 for none."""
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
    # By default its edge is round within a margin of 1 mm, also where it is thinner than that. A
    # margin can be changed where a shape is on a base, and is that of the shape wherever it is.
    carrier = client.createMultiBody(0.0, made)
    client.setCollisionFilterGroupMask(carrier, BASE, 0, 0)
    client.changeDynamics(carrier, BASE, collisionMargin=EDGE * min(size))
    return int(made)


def _set_up_joints(client: Any, joints: Sequence[Joint], moved: Sequence[At]) -> None:
    """Give joints their limits and their dry friction, a motor that stops a joint with no more than
    that force; without one a joint has no motor."""
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
    """Close the loops of a mechanism. Frames of a constraint are in those of the links' inertia."""
    for loop in mechanism.loops:
        turns = (UNTURNED, UNTURNED) if loop.kind == "connect" else (loop.attitude, UNTURNED)
        frames = [
            _within(inertial, homes[body], place, turn)
            for body, place, turn in zip(loop.bodies, loop.places, turns, strict=True)
        ]
        ends = [(homes[i], *frame) for i, frame in zip(loop.bodies, frames, strict=True)]
        if ends[0][0].tree == NONE:  # the world can be the second alone
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
    """A frame of a body, by its place [m] and its attitude, a quaternion, scalar first, as Bullet
    wants it: in the principal frame of inertia of the body's link, with the scalar last."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_quat(attitude, scalar_first=True)
    if home.tree == NONE:
        return place.tolist(), turn.as_quat().tolist()
    centre, axes = inertial[home.tree, home.link]
    back = Rotation.from_quat(axes).inv()
    return back.apply(place - home.origin - centre).tolist(), (back * turn).as_quat().tolist()
