"""Builds the DART world of a mechanism: a skeleton for each tree of bodies, and skeletons for the
shapes of the world.

A joint of DART moves one body node. If a body has several joints, the last joint moves the node of
the body, and each joint before it moves a node with next to no mass.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product
from types import MappingProxyType
from typing import Any

import dartpy
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.joints import TURNING, joint_name, joints_of_body
from plumbob.engines.adapters.refusals import (
    names_of,
    refuse,
    refused_friction,
    refused_parts,
    refused_shapes,
)
from plumbob.engines.adapters.shape_copies import add_shape_copies
from plumbob.engines.mechanism import Body, Joint, Mechanism, Shape, Touch
from plumbob.engines.method import Unsupported
from plumbob.engines.peer_model import rotation

# [kg], [kg m^2] mass and moments of nodes without a body: DART refuses 0, and no bit of a motion
# depends on a value as small as this one
LEAST = 1e-30
# [m] largest gap of a loop at the start; for a weld also the largest difference of the entries of
# the rotation matrices
OPEN = 1e-9
# [m] thickness added to shapes: DART finds contacts only between overlapping shapes
DEPTH = 1e-12
NO_FRICTION = 1e-3  # largest coefficient of friction that DART takes for none
KINDS = MappingProxyType(
    {"hinge": "Revolute", "slide": "Prismatic", "ball": "Ball", "free": "Free"}
)
Surface = tuple[float, float]
"""The coefficients of friction and of restitution of a pair of shapes."""
Layer = tuple[int, int]
"""The number of a body, and the number of the node that carries some of the body's shapes: 0 for
the node of the body itself."""
ShapeKey = tuple[Layer, str]
"""The layer of a shape node, and the name of the shape node."""


@dataclass(frozen=True)
class Built:
    """A mechanism in a DART world. Its loops are added by `close_loops`, in a state in which they
    are closed."""

    world: Any
    nodes: tuple[Any, ...]  # one for each body; None for the world
    joints: tuple[Any, ...]  # one for each joint


def build(mechanism: Mechanism, step: float) -> Built:
    """The world of a mechanism at a time step [s]; raises Unsupported."""
    refuse(refused_features(mechanism))
    world = dartpy.simulation.World()
    world.setTimeStep(step)
    world.setGravity(mechanism.gravity)
    no_sleep = dartpy.simulation.DeactivationOptions()
    no_sleep.mEnabled = False
    world.setDeactivationOptions(no_sleep)
    if any(shape.kind == "capsule" for shape in mechanism.shapes):
        # DART's default detector treats a capsule as a sphere.
        world.setCollisionDetector(dartpy.collision.OdeCollisionDetector())
    nodes, joints = _build_trees(mechanism)
    skeletons = dict.fromkeys(node.getSkeleton() for node in nodes if node is not None)
    _add_shapes(mechanism, world, nodes)
    for skeleton in skeletons:
        world.addSkeleton(skeleton)
    return Built(world, nodes, joints)


def refused_features(mechanism: Mechanism) -> Iterator[str]:
    """Names the features of a mechanism that DART, or this builder, cannot express."""
    yield from refused_parts(mechanism)
    for joint in mechanism.joints:
        yield from _refused_features_of_joint(joint, mechanism)
    if {"capsule", "ellipsoid"} <= {shape.kind for shape in mechanism.shapes}:
        yield "capsules with ellipsoids: no collision detector has both"
    yield from refused_shapes(mechanism)
    for touch in mechanism.touching:
        names = names_of(mechanism, touch)
        yield from refused_friction(touch, names)
        if 0.0 < touch.sliding[0] <= NO_FRICTION:
            yield f"friction of {names}, {NO_FRICTION} or less"


def _refused_features_of_joint(joint: Joint, mechanism: Mechanism) -> Iterator[str]:
    """Names the features of a joint that DART, or this builder, cannot express."""
    name = joint_name(mechanism, joint)
    turning = joint.kind in TURNING
    # DART's constraint solver turns limits and dry friction into impulses.
    has_impulses = joint.limits is not None or bool(np.any(joint.friction_loss))
    if turning and (joint.stiffness or has_impulses):
        yield f"spring, limit or dry friction of joint {name}, which is a {joint.kind} joint"
    if not np.any(joint.armature):
        return
    # An armature is expressed by a damper, and the impulses of DART's constraints ignore dampers.
    if turning:
        yield f"armature of joint {name}, which is a {joint.kind} joint"
    elif has_impulses or mechanism.loops or mechanism.touching:
        yield f"armature of joint {name}, beside contacts, loops, limits or dry friction"


def _build_trees(mechanism: Mechanism) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Builds the skeletons of a mechanism. Returns DART's node for each body, None for the world,
    and DART's joint for each joint."""
    nodes: list[Any] = [None]
    joints: dict[int, Any] = {}
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        node = nodes[body.parent]
        skeleton = dartpy.dynamics.Skeleton(str(number)) if node is None else node.getSkeleton()
        joint_numbers = joints_of_body(mechanism, number)
        for joint_number in joint_numbers:
            joints[joint_number], node = _add_joint(
                mechanism.joints[joint_number],
                body,
                skeleton,
                node,
                first=joint_number == joint_numbers[0],
            )
            node.setInertia(_tiny_inertia())
        if not joint_numbers:
            weld, node = _add_node(skeleton, "Weld", node)
            weld.setTransformFromParentBodyNode(transform(body.place, body.attitude))
        node.setInertia(_inertia(body.mass, body.centre, body.inertia))
        node.setGravityMode(not body.carried)
        nodes.append(node)
    return tuple(nodes), tuple(joints[number] for number in sorted(joints))


def _add_node(skeleton: Any, kind: str, above: Any) -> tuple[Any, Any]:
    """Adds a joint of a kind, and the node that the joint moves, to a skeleton. The joint connects
    the node to the node `above`, or to the world if that is None."""
    create = getattr(skeleton, f"create{kind}JointAndBodyNodePair")
    joint, node = create() if above is None else create(above)
    return joint, node


def _inertia(mass: float, centre: Array, moments: Array) -> Any:
    """DART's inertia of a mass [kg], a centre [m] and moments [kg m^2] about the centre."""
    return dartpy.dynamics.Inertia(max(mass, LEAST), centre, moments)


def _tiny_inertia() -> Any:
    """DART's inertia of a node without a body."""
    return _inertia(LEAST, np.zeros(3), LEAST * np.eye(3))


def transform(place: Array, attitude: Array | None = None) -> Any:
    """DART's transform to a place [m], with an attitude, a quaternion, or without a rotation."""
    isometry = dartpy.math.Isometry3()
    isometry.set_translation(place)
    if attitude is not None:
        isometry.set_rotation(rotation(attitude))
    return isometry


def _add_joint(
    joint: Joint, body: Body, skeleton: Any, above: Any, *, first: bool
) -> tuple[Any, Any]:
    """Adds a joint of a body behind the node `above`; returns DART's joint, and the node that it
    moves. If the joint is the `first` of its body, its frame in the parent includes the place and
    the attitude of the body."""
    dart_joint, node = _add_node(skeleton, KINDS[joint.kind], above)
    for degree, damping in enumerate(joint.damping.tolist()):
        dart_joint.setDampingCoefficient(degree, damping)
    if joint.kind == "free":  # the coordinates of the joint are those of the body in the world
        return dart_joint, node
    frame_in_parent = transform(joint.place)
    if first:
        place = body.place + rotation(body.attitude) @ joint.place
        frame_in_parent = transform(place, body.attitude)
    dart_joint.setTransformFromParentBodyNode(frame_in_parent)
    dart_joint.setTransformFromChildBodyNode(transform(joint.place))
    if joint.kind == "ball":
        return dart_joint, node
    dart_joint.setAxis(joint.axis)
    reference = float(joint.reference[0])  # DART's coordinate is 0 in the pose of the file
    dart_joint.setSpringStiffness(0, joint.stiffness)
    dart_joint.setRestPosition(0, float(joint.rest[0]) - reference)
    dart_joint.setCoulombFriction(0, float(joint.friction_loss[0]))
    if joint.limits is not None:
        dart_joint.setPositionLowerLimit(0, joint.limits[0] - reference)
        dart_joint.setPositionUpperLimit(0, joint.limits[1] - reference)
        dart_joint.setLimitEnforcement(True)
    if joint.velocity is not None:
        dart_joint.setActuatorType(dartpy.dynamics.ActuatorType.ACCELERATION)
    return dart_joint, node


def close_loops(mechanism: Mechanism, built: Built) -> None:
    """Adds constraints that close the loops of a mechanism. Raises Unsupported if a loop is open in
    the present state of the world."""
    for loop in mechanism.loops:
        nodes = [built.nodes[body] for body in loop.bodies]
        frames = [
            transform(np.zeros(3)) if node is None else node.getWorldTransform()
            for node in nodes
        ]
        points = [
            frame.multiply(place) for frame, place in zip(frames, loop.places, strict=True)
        ]
        gap = np.abs(points[0] - points[1]).max()
        if loop.kind == "weld":
            first, second = (frame.rotation() for frame in frames)
            gap = max(gap, np.abs(first @ rotation(loop.attitude) - second).max())
        if gap > OPEN:
            raise Unsupported(f"feature loop {loop.name}, which is open at the start")
        moving_nodes = [node for node in nodes if node is not None]
        if loop.kind == "connect":
            constraint = dartpy.constraint.BallJointConstraint(*moving_nodes, points[0])
        else:
            constraint = dartpy.constraint.WeldJointConstraint(*moving_nodes)
        built.world.getConstraintSolver().addConstraint(constraint)


def _add_shapes(mechanism: Mechanism, world: Any, nodes: Sequence[Any]) -> None:
    """Adds the shapes of a mechanism to the nodes, and lets only the pairs in `mechanism.touching`
    collide; raises Unsupported.

    A pair of DART's shapes has the smaller of their two coefficients of friction. Of several copies
    of a shape, the first is on the node of its body, and the others are on nodes that are welded to
    that node.
    """
    layers = Layers(world, nodes)

    def add(number: int, surface: Surface) -> ShapeKey:
        """Adds a copy of a shape with its coefficients."""
        return layers.add(number, mechanism.shapes[number], surface)

    pairs = add_shape_copies(mechanism, _surface, add)
    _filter_collisions(world, layers, pairs)


def _surface(touch: Touch) -> Surface:
    """The coefficients of a pair of shapes."""
    return touch.sliding[0], touch.restitution


@dataclass(frozen=True)
class Layers:
    """The nodes that carry shapes, and the names of the shape nodes on each."""

    world: Any
    body_nodes: Sequence[Any]  # node of each body; None for the world
    carriers: dict[Layer, Any] = field(default_factory=dict)
    names: defaultdict[Layer, list[str]] = field(default_factory=lambda: defaultdict(list))
    copies: Counter[int] = field(default_factory=Counter)  # copies so far, by number of a shape

    def add(self, number: int, shape: Shape, surface: Surface) -> ShapeKey:
        """Adds a copy of the shape with this `number` to the next layer of its body that has no
        copy of it."""
        copy = self.copies[number]
        self.copies[number] += 1
        layer = (shape.body, copy)
        name = f"{number} {copy}"
        if layer not in self.carriers:
            self.carriers[layer] = _carrier(self.world, self.body_nodes[shape.body], copy)
        self.names[layer].append(name)
        _add_shape(self.carriers[layer], shape, name, surface)
        return layer, name


def _carrier(world: Any, node: Any, layer: int) -> Any:
    """The node that carries the shapes of a layer of a body. For layer 0 it is the `node` of the
    body; for other layers, a new node that is welded to it. A body whose `node` is None is the
    world: each of its layers is a new skeleton."""
    if node is None:
        skeleton = dartpy.dynamics.Skeleton(f"world {layer}")
        _, carrier = _add_node(skeleton, "Weld", None)
        world.addSkeleton(skeleton)
        return carrier
    if layer == 0:
        return node
    _, carrier = _add_node(node.getSkeleton(), "Weld", node)
    carrier.setInertia(_tiny_inertia())
    return carrier


def _add_shape(node: Any, shape: Shape, name: str, surface: Surface) -> None:
    """Adds a shape with its coefficients to a node."""
    friction, restitution = surface
    shape_node = node.createShapeNode(_collision_shape(shape), name)
    shape_node.setRelativeTransform(transform(shape.place, shape.attitude))
    shape_node.createCollisionAspect()
    aspect = shape_node.createDynamicsAspect()
    aspect.setFrictionCoeff(friction)
    # DART gives a pair of shapes the product of their coefficients of restitution.
    aspect.setRestitutionCoeff(math.sqrt(restitution))


def _collision_shape(shape: Shape) -> Any:
    """DART's collision shape. It is thicker by DEPTH on all sides, unless it is a plane."""
    sizes = (shape.size + DEPTH).tolist()
    match shape.kind:
        case "plane":
            return dartpy.dynamics.PlaneShape([0.0, 0.0, 1.0], 0.0)
        case "sphere":
            return dartpy.dynamics.SphereShape(*sizes)
        case "capsule":
            return dartpy.dynamics.CapsuleShape(sizes[0], 2.0 * shape.size[1])
        case "cylinder":
            return dartpy.dynamics.CylinderShape(sizes[0], 2.0 * sizes[1])
        case "box":
            return dartpy.dynamics.BoxShape([2.0 * half for half in sizes])
    return dartpy.dynamics.EllipsoidShape([2.0 * half for half in sizes])


def _filter_collisions(
    world: Any, layers: Layers, pairs: Sequence[tuple[ShapeKey, ShapeKey]]
) -> None:
    """Lets only the pairs of shapes collide that can touch. DART filters pairs of nodes, and not
    pairs of shapes: raises Unsupported if some shapes of two nodes can touch and others cannot."""
    touching = {frozenset(pair) for pair in pairs}
    touching_layers = {frozenset((layer, other)) for (layer, _), (other, _) in pairs}
    collision_filter = world.getConstraintSolver().getCollisionOption().collisionFilter
    for first, second in combinations(layers.carriers, 2):
        node, other_node = layers.carriers[first], layers.carriers[second]
        if frozenset((first, second)) not in touching_layers:
            collision_filter.addBodyNodePairToBlackList(node, other_node)
            continue
        for name, other_name in product(layers.names[first], layers.names[second]):
            if frozenset(((first, name), (second, other_name))) not in touching:
                raise Unsupported(
                    "feature contact of two bodies of which only some shapes touch"
                )
        skeleton = node.getSkeleton()
        if skeleton.getName() == other_node.getSkeleton().getName():
            skeleton.enableSelfCollisionCheck()
            skeleton.enableAdjacentBodyCheck()
