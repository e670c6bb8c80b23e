"""Builds the Drake diagram of a mechanism: a multibody plant with its geometry, and the source of
the motors' forces.

A joint of Drake moves one body. If a body has several joints, the last joint moves the body, and
each joint before it moves a body without mass.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from types import MappingProxyType
from typing import Any

import numpy as np
from pydrake import geometry
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody import tree
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlantConfig,
)
from pydrake.systems.framework import DiagramBuilder

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.drake.motors import Motors, add_motors, connected_motors
from plumbob.engines.adapters.joints import joint_name, joints_of_body
from plumbob.engines.adapters.refusals import (
    names_of,
    refuse,
    refused_friction,
    refused_parts,
    refused_shapes,
)
from plumbob.engines.adapters.shape_copies import add_shape_copies
from plumbob.engines.mechanism import Body, Joint, Mechanism, Shape
from plumbob.engines.method import Options
from plumbob.engines.peer_model import rotation

KINDS = MappingProxyType(
    {
        "hinge": tree.RevoluteJoint,
        "slide": tree.PrismaticJoint,
        "ball": tree.BallRpyJoint,
        "free": tree.QuaternionFloatingJoint,
    }
)
SPRINGS = MappingProxyType({"hinge": tree.RevoluteSpring, "slide": tree.PrismaticSpring})
GROUND = 100.0  # [m] edge of the block that stands for a plane: the plane is its top
WITHOUT_LOOPS = "tamsi"  # contact solver that does not support constraints of loops


@dataclass(frozen=True)
class Built:
    """A mechanism in a Drake diagram."""

    diagram: Any
    plant: Any
    joints: tuple[Any, ...]  # one for each joint
    motors: Motors

    def plant_context(self, context: Any) -> Any:
        """The plant's part of a context of the diagram; it is mutable."""
        return self.plant.GetMyMutableContextFromRoot(context)


def build(mechanism: Mechanism, settings: Options, control: float = 0.0) -> Built:
    """The diagram of a mechanism whose plant has these settings. If the plant is continuous, the
    forces of the source are held for `control` [s]. Raises Unsupported."""
    approximation = settings.get("discrete_contact_approximation", "")
    refuse(refused_features(mechanism, approximation))
    builder = DiagramBuilder()
    plant, scene = AddMultibodyPlant(MultibodyPlantConfig(**settings), builder)
    plant.mutable_gravity_field().set_gravity_vector(mechanism.gravity)
    bodies, joints = _add_trees(mechanism, plant)
    motors = add_motors(mechanism, plant, joints)
    _close_loops(mechanism, plant, bodies)
    pairs = _add_shapes(mechanism, plant, bodies)
    plant.Finalize()
    if pairs:
        _filter_collisions(scene, pairs)
    motors = connected_motors(builder, plant, motors, joints, control)
    return Built(builder.Build(), plant, joints, motors)


def refused_features(mechanism: Mechanism, approximation: str = "") -> Iterator[str]:
    """Names the features of a mechanism that Drake with this contact `approximation`, or this
    builder, cannot express."""
    yield from refused_parts(mechanism)
    for joint in mechanism.joints:
        yield from _refused_features_of_joint(joint, mechanism)
    if approximation == WITHOUT_LOOPS:
        for loop in mechanism.loops:
            yield f"loop {loop.name}, which TAMSI does not support"
    yield from refused_shapes(mechanism)
    for touch in mechanism.touching:
        names = names_of(mechanism, touch)
        if touch.restitution:
            yield f"restitution of {names}"
        yield from refused_friction(touch, names)


def _refused_features_of_joint(joint: Joint, mechanism: Mechanism) -> Iterator[str]:
    """Names the features of a joint that Drake, or this builder, cannot express."""
    name = joint_name(mechanism, joint)
    if np.any(joint.friction_loss):
        yield f"dry friction of joint {name}"
    if joint.kind in KINDS.keys() - SPRINGS.keys():
        if joint.stiffness or joint.limits or np.any(joint.armature):
            yield f"spring, limit or armature of joint {name}, which is a {joint.kind} joint"
        triples = np.split(joint.damping, len(joint.damping) // 3)
        if any(np.ptp(triple) for triple in triples):
            yield f"damping of joint {name}, different along its axes"


def _add_trees(mechanism: Mechanism, plant: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Adds the bodies and the joints of a mechanism to a plant. Returns Drake's body for each body,
    and Drake's joint for each joint."""
    weightless = plant.AddModelInstance("weightless")
    plant.set_gravity_enabled(weightless, False)
    heavy = plant.AddModelInstance("heavy")
    bodies = [plant.world_body()]
    joints: dict[int, Any] = {}
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        instance = weightless if body.carried else heavy
        drake_body = plant.AddRigidBody(f"body_{number}", instance, _inertia(body))
        joint_numbers = joints_of_body(mechanism, number)
        above = bodies[body.parent].body_frame()
        drawn = transform(body.place, body.attitude)
        for joint_number in joint_numbers:
            moved = drake_body
            if joint_number != joint_numbers[-1]:
                massless = tree.SpatialInertia.Zero()
                moved = plant.AddRigidBody(f"before_{joint_number}", heavy, massless)
            joint = mechanism.joints[joint_number]
            joints[joint_number] = _add_joint(plant, joint_number, joint, above, drawn, moved)
            above = moved.body_frame()
            drawn = RigidTransform()
        if not joint_numbers:
            plant.WeldFrames(above, drake_body.body_frame(), drawn)
        bodies.append(drake_body)
    return tuple(bodies), tuple(joints[number] for number in sorted(joints))


def _inertia(body: Body) -> Any:
    """Drake's inertia of a body."""
    (xx, yy, zz) = np.diag(body.inertia)
    (xy, xz, yz) = body.inertia[np.triu_indices(3, 1)]
    about_centre = tree.RotationalInertia(xx, yy, zz, xy, xz, yz)
    return tree.SpatialInertia.MakeFromCentralInertia(body.mass, body.centre, about_centre)


def transform(place: Array, attitude: Array | None = None) -> Any:
    """Drake's transform to a place [m], with an attitude, a quaternion, or without a rotation."""
    if attitude is None:
        return RigidTransform(place)
    return RigidTransform(RotationMatrix(rotation(attitude)), place)


def _add_joint(
    plant: Any, number: int, joint: Joint, above: Any, drawn: Any, moved: Any
) -> Any:
    """Adds a joint with its spring and its limits to a plant; returns Drake's joint. It connects
    the body `moved` to the frame `above`. In the drawing, `moved` has the pose `drawn` in that
    frame."""
    kind = KINDS[joint.kind]
    name = f"joint_{number}"
    if joint.kind == "free":  # the coordinates of the joint are those of the body in the world
        damping_of_turning = joint.damping[3]
        damping_of_moving = joint.damping[0]
        frame = moved.body_frame()
        return plant.AddJoint(kind(name, above, frame, damping_of_turning, damping_of_moving))
    at_joint = transform(joint.place)
    frame_above = tree.FixedOffsetFrame(f"before_{name}", above, drawn.multiply(at_joint))
    frame_moved = tree.FixedOffsetFrame(f"after_{name}", moved.body_frame(), at_joint)
    frames = (plant.AddFrame(frame_above), plant.AddFrame(frame_moved))
    damping = float(joint.damping[0])
    if joint.kind == "ball":
        return plant.AddJoint(kind(name, *frames, damping))
    drake_joint = plant.AddJoint(kind(name, *frames, joint.axis, damping=damping))
    reference = float(joint.reference[0])  # Drake's coordinate is 0 in the reference pose
    if joint.stiffness:
        drake_rest = float(joint.rest[0]) - reference
        plant.AddForceElement(SPRINGS[joint.kind](drake_joint, drake_rest, joint.stiffness))
    if joint.limits is not None:
        low, high = joint.limits
        drake_joint.set_position_limits([low - reference], [high - reference])
    return drake_joint


def _close_loops(mechanism: Mechanism, plant: Any, bodies: Sequence[Any]) -> None:
    """Adds constraints that close the loops of a mechanism. In a plant without contacts, Drake ends
    the process if a constraint acts on the world's body. So a massless body is welded to the world,
    and constraints act on that body."""
    if any(0 in loop.bodies for loop in mechanism.loops):
        massless = tree.SpatialInertia.Zero()
        ground = plant.AddRigidBody("ground", tree.default_model_instance(), massless)
        plant.WeldFrames(plant.world_frame(), ground.body_frame())
        bodies = [ground, *bodies[1:]]
    for loop in mechanism.loops:
        first, second = (bodies[number] for number in loop.bodies)
        place, other_place = loop.places
        if loop.kind == "connect":
            plant.AddBallConstraint(first, place, second, other_place)
        else:
            frame = transform(place, loop.attitude)
            plant.AddWeldConstraint(first, frame, second, transform(other_place))


def _add_shapes(
    mechanism: Mechanism, plant: Any, bodies: Sequence[Any]
) -> list[tuple[Any, Any]]:
    """Adds the shapes of a mechanism to Drake's bodies; returns the identifiers of the two
    geometries of each pair of shapes that can touch.

    A shape of Drake has one coefficient of friction, and two shapes with coefficients m and n have
    the coefficient 2 m n/(m + n)."""

    def add(number: int, friction: float) -> Any:
        """Adds the shape with a number to its body, with a coefficient of friction."""
        shape = mechanism.shapes[number]
        return _add_shape(plant, bodies[shape.body], shape, friction)

    return add_shape_copies(mechanism, lambda touch: touch.sliding[0], add)


def _add_shape(plant: Any, body: Any, shape: Shape, friction: float) -> Any:
    """Adds a shape with its coefficient to a body; returns the identifier of Drake's geometry."""
    number = plant.num_collision_geometries()
    pose = transform(shape.place, shape.attitude)
    if shape.kind == "plane":
        pose = pose.multiply(transform(np.array([0.0, 0.0, -0.5 * GROUND])))
    name = f"shape_{number}"
    law = CoulombFriction(friction, friction)
    return plant.RegisterCollisionGeometry(body, pose, _collision_shape(shape), name, law)


def _collision_shape(shape: Shape) -> Any:
    """Drake's shape. A plane is a block, because Drake prints a warning for each half space."""
    sizes = shape.size.tolist()
    match shape.kind:
        case "plane":
            return geometry.Box(GROUND, GROUND, GROUND)
        case "sphere":
            return geometry.Sphere(*sizes)
        case "capsule":
            return geometry.Capsule(sizes[0], 2.0 * sizes[1])
        case "cylinder":
            return geometry.Cylinder(sizes[0], 2.0 * sizes[1])
        case "box":
            return geometry.Box(*(2.0 * half for half in sizes))
    return geometry.Ellipsoid(*sizes)


def _filter_collisions(scene: Any, pairs: Sequence[tuple[Any, Any]]) -> None:
    """Lets only these pairs of geometries collide."""
    geometries = list(dict.fromkeys(chain.from_iterable(pairs)))
    all_geometries = geometry.GeometrySet(geometries)
    declaration = geometry.CollisionFilterDeclaration().ExcludeWithin(all_geometries)
    for first, second in pairs:
        declaration.AllowBetween(geometry.GeometrySet(first), geometry.GeometrySet(second))
    scene.collision_filter_manager().Apply(declaration)
