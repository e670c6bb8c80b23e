"""Builds the DART world of a mechanism: a skeleton for each tree of bodies, and skeletons for the
shapes of the world.

A joint of DART moves one body node. If a body has several joints, the last joint moves the node of
the body, and each joint before it moves a node with next to no mass.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from types import MappingProxyType
from typing import Any

import dartpy
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.refusals import (
    names_of,
    refused_friction,
    refused_parts,
    refused_shapes,
)
from plumbob.engines.mechanism import Body, Joint, Mechanism, Shape
from plumbob.engines.method import Unsupported
from plumbob.engines.peer_model import rotation

# [kg], [kg m^2] mass and moments of nodes without a body: DART refuses 0, and no bit of a motion
# depends on a value as small as this one
LEAST = 1e-30
# [m] largest gap of a loop at the start; for a weld also the largest difference of the entries of
# the rotation matrices
OPEN = 1e-9
DEPTH = (
    1e-12  # [m] thickness added to shapes: DART finds contacts only between overlapping shapes
)
NO_FRICTION = 1e-3  # largest coefficient of friction that DART takes for none
KINDS = MappingProxyType(
    {"hinge": "Revolute", "slide": "Prismatic", "ball": "Ball", "free": "Free"}
)
Surface = tuple[float, float]
"""The coefficients of friction and of restitution of a pair of shapes."""
Home = tuple[int, int]
"""The number of a body, and the number of the node that carries some of the body's shapes: 0 for
the node of the body itself."""
Touching = dict[tuple[str, str], tuple[int, float]]
"""{names of two shape nodes: number of the pair of shapes, and 1, or -1 in reverse order}."""


@dataclass(frozen=True)
class Built:
    """A mechanism in a DART world. Its loops are added by `close_loops`, in a state in which they
    are closed."""

    world: Any
    skeletons: tuple[Any, ...]  # one for each tree of bodies
    nodes: tuple[Any, ...]  # one for each body; None for the world
    joints: tuple[Any, ...]  # one for each joint
    touching: Touching
    smooth: bool  # whether there are no contacts, loops, limits or dry friction


def build(mechanism: Mechanism, step: float) -> Built:
    """The world of a mechanism at a time step [s]; raises Unsupported."""
    for feature in refused(mechanism):
        raise Unsupported(f"feature {feature}")
    world = dartpy.simulation.World()
    world.setTimeStep(step)
    world.setGravity(mechanism.gravity)
    awake = dartpy.simulation.DeactivationOptions()
    awake.mEnabled = False
    world.setDeactivationOptions(awake)
    if any(shape.kind == "capsule" for shape in mechanism.shapes):
        # DART's default detector treats a capsule as a sphere.
        world.setCollisionDetector(dartpy.collision.OdeCollisionDetector())
    nodes, joints = _trees(mechanism)
    skeletons = dict.fromkeys(node.getSkeleton() for node in nodes if node is not None)
    touching = _shapes(mechanism, world, nodes)
    for skeleton in skeletons:
        world.addSkeleton(skeleton)
    unilateral = any(map(acts_by_impulses, mechanism.joints))
    smooth = not (mechanism.loops or mechanism.touching or unilateral)
    return Built(world, tuple(skeletons), nodes, joints, touching, smooth)


def refused(mechanism: Mechanism) -> Iterator[str]:
    """Names the features of a mechanism that DART, or this builder, cannot express."""
    yield from refused_parts(mechanism)
    for joint in mechanism.joints:
        yield from _refused_of(joint, mechanism)
    if {"capsule", "ellipsoid"} <= {shape.kind for shape in mechanism.shapes}:
        yield "capsules beside ellipsoids: no collision detector has both"
    yield from refused_shapes(mechanism)
    for touch in mechanism.touching:
        names = names_of(mechanism, touch)
        yield from refused_friction(touch, names)
        if 0.0 < touch.sliding[0] <= NO_FRICTION:
            yield f"friction of {names}, {NO_FRICTION} or less"


def acts_by_impulses(joint: Joint) -> bool:
    """Whether a joint has limits or dry friction, which DART's constraint solver turns into
    impulses."""
    return joint.limits is not None or bool(np.any(joint.friction_loss))


def _refused_of(joint: Joint, mechanism: Mechanism) -> Iterator[str]:
    """Names the features of a joint that DART, or this builder, cannot express."""
    name = joint.name or f"of body {mechanism.bodies[joint.body].name}"
    turning = joint.kind in ("ball", "free")
    unilateral = acts_by_impulses(joint)
    if turning and (joint.stiffness or unilateral):
        yield f"spring, limit or dry friction of joint {name}, which is a {joint.kind} joint"
    # An armature is expressed by a damper, and the impulses of DART's constraints ignore dampers.
    impulses = bool(mechanism.loops or mechanism.touching) or unilateral
    if np.any(joint.armature) and (turning or impulses):
        yield f"armature of joint {name} that is a {joint.kind} joint, or beside constraints"


def _trees(mechanism: Mechanism) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Builds the skeletons of a mechanism. Returns DART's node for each body, None for the world,
    and DART's joint for each joint."""
    nodes: list[Any] = [None]
    joints: dict[int, Any] = {}
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        own = [i for i, joint in enumerate(mechanism.joints) if joint.body == number]
        above = nodes[body.parent]
        skeleton = (
            above.getSkeleton() if above is not None else dartpy.dynamics.Skeleton(str(number))
        )
        for i in own:
            first = above is nodes[body.parent]
            joints[i], above = _jointed(mechanism.joints[i], body, skeleton, above, first)
            above.setInertia(_inertia(LEAST, np.zeros(3), LEAST * np.eye(3)))
        if not own:
            weld, above = _paired(skeleton, "Weld", above)
            weld.setTransformFromParentBodyNode(placed(body.place, body.attitude))
        above.setInertia(_inertia(body.mass, body.centre, body.inertia))
        above.setGravityMode(not body.carried)
        nodes.append(above)
    return tuple(nodes), tuple(joints[i] for i in range(len(mechanism.joints)))


def _paired(skeleton: Any, kind: str, above: Any) -> tuple[Any, Any]:
    """Adds a joint of a kind, and the node that the joint moves, to a skeleton. The joint connects
    the node to the node `above`, or to the world if that is None."""
    make = getattr(skeleton, f"create{kind}JointAndBodyNodePair")
    joint, node = make() if above is None else make(above)
    return joint, node


def _inertia(mass: float, centre: Array, moments: Array) -> Any:
    """DART's inertia of a mass [kg], a centre [m] and moments [kg m^2] about the centre."""
    return dartpy.dynamics.Inertia(max(mass, LEAST), centre, moments)


def placed(place: Array, attitude: Array | None = None) -> Any:
    """DART's transform to a place [m], with an attitude, a quaternion, or without a rotation."""
    transform = dartpy.math.Isometry3()
    transform.set_translation(place)
    if attitude is not None:
        transform.set_rotation(rotation(attitude))
    return transform


def _jointed(
    joint: Joint, body: Body, skeleton: Any, above: Any, first: bool
) -> tuple[Any, Any]:
    """Adds a joint of a body; returns DART's joint, and the node that it moves. If the joint is the
    first of its body, its frame in the parent includes the place and the attitude of the body."""
    made, node = _paired(skeleton, KINDS[joint.kind], above)
    for degree, damping in enumerate(joint.damping.tolist()):
        made.setDampingCoefficient(degree, damping)
    if joint.kind == "free":  # the coordinates of the joint are those of the body in the world
        return made, node
    place = joint.place
    if first:
        place = body.place + rotation(body.attitude) @ joint.place
    made.setTransformFromParentBodyNode(placed(place, body.attitude if first else None))
    made.setTransformFromChildBodyNode(placed(joint.place))
    if joint.kind == "ball":
        return made, node
    made.setAxis(joint.axis)
    drawn = float(joint.reference[0])  # DART's coordinate is 0 in the drawing
    made.setSpringStiffness(0, joint.stiffness)
    made.setRestPosition(0, float(joint.rest[0]) - drawn)
    made.setCoulombFriction(0, float(joint.friction_loss[0]))
    if joint.limits is not None:
        made.setPositionLowerLimit(0, joint.limits[0] - drawn)
        made.setPositionUpperLimit(0, joint.limits[1] - drawn)
        made.setLimitEnforcement(True)
    if joint.velocity is not None:
        made.setActuatorType(dartpy.dynamics.ActuatorType.ACCELERATION)
    return made, node


def close_loops(mechanism: Mechanism, built: Built) -> None:
    """Adds constraints that close the loops of a mechanism. Raises Unsupported if a loop is open in
    the present state of the world."""
    for loop in mechanism.loops:
        nodes = [built.nodes[i] for i in loop.bodies]
        frames = [placed(np.zeros(3)) if x is None else x.getWorldTransform() for x in nodes]
        points = [x.multiply(at) for x, at in zip(frames, loop.places, strict=True)]
        gap = np.abs(points[0] - points[1]).max()
        if loop.kind == "weld":
            first, second = (frame.rotation() for frame in frames)
            gap = max(gap, np.abs(first @ rotation(loop.attitude) - second).max())
        if gap > OPEN:
            raise Unsupported(f"feature loop {loop.name}, which is open at the start")
        moved = [node for node in nodes if node is not None]
        if loop.kind == "connect":
            made = dartpy.constraint.BallJointConstraint(*moved, points[0])
        else:
            made = dartpy.constraint.WeldJointConstraint(*moved)
        built.world.getConstraintSolver().addConstraint(made)


def _shapes(mechanism: Mechanism, world: Any, nodes: Sequence[Any]) -> Touching:
    """Adds the shapes of a mechanism to the nodes, and lets only the pairs in `mechanism.touching`
    collide; raises Unsupported.

    A shape of DART has one coefficient of friction, and a pair of shapes has the smaller of its two
    coefficients. If a shape has several coefficients, there is a copy of the shape for each, on a
    node that is welded to the node of the body.
    """
    surfaces = defaultdict[int, list[Surface]](list)
    carriers = dict[Home, Any]()
    homes = dict[str, Home]()
    touching: Touching = {}
    for number, touch in enumerate(mechanism.touching):
        surface = (touch.sliding[0], touch.restitution)
        names = list[str]()
        for i in touch.shapes:
            shape = mechanism.shapes[i]
            if surface not in surfaces[i]:
                surfaces[i].append(surface)
            home = (shape.body, surfaces[i].index(surface))
            names.append(f"{i} {home[1]}")
            if home not in carriers:
                carriers[home] = _carrier(world, nodes[shape.body], home[1])
            if names[-1] not in homes:
                homes[names[-1]] = home
                _add_shape(carriers[home], shape, names[-1], surface)
        touching[names[0], names[1]] = (number, 1.0)
        touching[names[1], names[0]] = (number, -1.0)
    _keep_apart(world, carriers, homes, touching)
    return touching


def _carrier(world: Any, node: Any, layer: int) -> Any:
    """The node that carries the shapes of a layer of a body. For layer 0 it is the `node` of the
    body; for other layers, a new node that is welded to it. A body whose `node` is None is the
    world: each of its layers is a new skeleton."""
    if node is None:
        skeleton = dartpy.dynamics.Skeleton(f"world {layer}")
        carrier = _paired(skeleton, "Weld", None)[1]
        world.addSkeleton(skeleton)
        return carrier
    if layer == 0:
        return node
    carrier = _paired(node.getSkeleton(), "Weld", node)[1]
    carrier.setInertia(_inertia(LEAST, np.zeros(3), LEAST * np.eye(3)))
    return carrier


def _add_shape(node: Any, shape: Shape, name: str, surface: Surface) -> None:
    """Adds a shape with its coefficients to a node."""
    made = node.createShapeNode(_made(shape), name)
    made.setRelativeTransform(placed(shape.place, shape.attitude))
    made.createCollisionAspect()
    aspect = made.createDynamicsAspect()
    aspect.setFrictionCoeff(surface[0])
    # DART gives a pair of shapes the product of their coefficients of restitution.
    aspect.setRestitutionCoeff(math.sqrt(surface[1]))


def _made(shape: Shape) -> Any:
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


def _keep_apart(
    world: Any, carriers: Mapping[Home, Any], homes: Mapping[str, Home], touching: Touching
) -> None:
    """Lets only the pairs of shapes collide that can touch. DART filters pairs of nodes, and not
    pairs of shapes: raises Unsupported if some shapes of two nodes can touch and others cannot."""
    together = {frozenset((homes[one], homes[other])) for one, other in touching}
    on = {home: [name for name in homes if homes[name] == home] for home in carriers}
    chosen = world.getConstraintSolver().getCollisionOption()
    for one, other in combinations(carriers, 2):
        nodes = (carriers[one], carriers[other])
        if frozenset((one, other)) not in together:
            chosen.collisionFilter.addBodyNodePairToBlackList(*nodes)
            continue
        if any(pair not in touching for pair in product(on[one], on[other])):
            raise Unsupported("feature bodies of whose shapes some touch and others do not")
        skeleton = nodes[0].getSkeleton()
        if skeleton.getName() == nodes[1].getSkeleton().getName():
            skeleton.enableSelfCollisionCheck()
            skeleton.enableAdjacentBodyCheck()
