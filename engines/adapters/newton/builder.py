"""Builds the Newton model of a mechanism for one of Newton's solvers.

All hinges and slides of a body are one joint of Newton with up to six axes, so that no massless
bodies are needed between them. A coordinate of Newton is MuJoCo's coordinate minus the coordinate
in the reference pose.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations
from types import MappingProxyType
from typing import Any, Literal

import newton
import numpy as np
import warp

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.joints import (
    ONE_AXIS,
    joint_name,
    joint_places,
    joints_of_body,
)
from plumbob.engines.adapters.refusals import (
    names_of,
    refuse,
    refused_directions,
    refused_parts,
    refused_shapes,
    refused_weights,
)
from plumbob.engines.adapters.rotors import moved_inertia
from plumbob.engines.adapters.shape_copies import add_shape_copies
from plumbob.engines.mechanism import Body, Joint, Mechanism, Shape, Touch
from plumbob.engines.peer_model import rotation
from plumbob.models.idealisations import Velocity

SolverName = Literal["featherstone", "xpbd", "mujoco"]
# A rotor that prescribes a motion has the inertia of all that it moves, times such a ratio. Each is
# the largest that single precision allows: the first where equations are solved directly, the
# second where MuJoCo Warp iterates.
HOLDING, HOLDING_BESIDE_CONSTRAINTS = 1e10, 1e4
RIGID = 1e12  # [N/m] or [N m/rad] stiffness of a drive that prescribes a motion in XPBD
SIZES = MappingProxyType(
    {
        "plane": ("width", "length"),  # infinite if both are 0
        "sphere": ("radius",),
        "capsule": ("radius", "half_height"),
        "cylinder": ("radius", "half_height"),
        "box": ("hx", "hy", "hz"),
        "ellipsoid": ("rx", "ry", "rz"),
    }
)
BodyFrame = tuple[int, Any]
"""The number of the link that a body belongs to, -1 for the world, and the body's frame on that
link, a transform of Newton."""
Surface = tuple[float, float, float, float]
"""The coefficients of sliding friction, of torsional friction, of rolling friction and of
restitution."""


@dataclass(frozen=True)
class Held:
    """A hinge or a slide whose motion is prescribed by a rotor or, if `rotor` is 0, by a drive."""

    place: int  # number of the coordinate
    degree: int  # number of the degree of freedom
    rotor: float  # inertia of the rotor [kg m^2] or [kg]
    velocity: Velocity


@dataclass(frozen=True)
class Built:
    """A mechanism in a Newton model. The coordinates of its joints come first, in their order."""

    mechanism: Mechanism
    model: Any
    pipeline: Any  # Newton's detection of contacts; None if the solver needs none
    centres: tuple[Array, ...]
    """The centre of mass of the link that each joint moves, in the frame of the link [m]."""
    held: tuple[Held, ...]


def build(mechanism: Mechanism, solver: SolverName) -> Built:
    """The model of a mechanism for a solver; raises Unsupported."""
    refuse(refused_features(mechanism, solver))
    builder = newton.ModelBuilder(up_axis=newton.Axis.Z)
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    body_frames = _add_trees(mechanism, solver, builder)
    _close_loops(mechanism, body_frames, builder)
    _add_shapes(mechanism, body_frames, builder)
    # Newton's check of inertias would increase the moments of inertia of a point mass.
    model = builder.finalize(
        skip_validation_inertia=True, skip_validation_joints=bool(mechanism.loops)
    )
    model.set_gravity(mechanism.gravity.tolist())
    links = [body_frames[joint.body][0] for joint in mechanism.joints]
    needs_contacts = bool(mechanism.touching) and solver == "xpbd"
    return Built(
        mechanism=mechanism,
        model=model,
        pipeline=newton.CollisionPipeline(model) if needs_contacts else None,
        centres=tuple(np.array(builder.body_com[link], float) for link in links),
        held=tuple(_held_joints(mechanism, solver)),
    )


def _held_joints(mechanism: Mechanism, solver: SolverName) -> Iterator[Held]:
    """The hinges and slides whose motion is prescribed."""
    places = joint_places(mechanism.joints)
    for joint, (place, place_of_rates) in zip(mechanism.joints, places, strict=True):
        if joint.velocity is not None:
            rotor = _rotor_inertia(mechanism, joint, solver)
            yield Held(place.start, place_of_rates.start, rotor, joint.velocity)


def refused_features(mechanism: Mechanism, solver: SolverName) -> Iterator[str]:
    """Names the features of a mechanism that a solver of Newton, or this builder, cannot
    express."""
    yield from refused_parts(mechanism)
    yield from refused_weights(mechanism)
    yield from _refused_bodies(mechanism)
    for joint in mechanism.joints:
        name = joint_name(mechanism, joint)
        for part, reason in _refused_parts_of_joint(joint, solver):
            yield f"{part} of joint {name}, {reason}"
    for motor in mechanism.actuators:
        sprung = any(motor.bias[1:])
        if sprung and (solver == "xpbd" or motor.force_range):
            yield f"servo {motor.name} with XPBD, or with a limited force"
    if any(joint.force_range for joint in mechanism.joints):
        yield "limit of the sum of forces on a joint"
    yield from refused_shapes(mechanism)
    yield from _refused_constraints(mechanism, solver)


def _refused_bodies(mechanism: Mechanism) -> Iterator[str]:
    """Names the bodies whose joints Newton's joint with several axes cannot express."""
    for number in range(1, len(mechanism.bodies)):
        joints = _joints_of(mechanism, number)
        slides = [joint.kind == "slide" for joint in joints]
        slides_first = slides == sorted(slides, reverse=True)
        one_place = all(np.array_equal(joints[0].place, joint.place) for joint in joints)
        if len(joints) > 1 and not (slides_first and one_place):
            name = mechanism.bodies[number].name
            yield f"joints of body {name} that are not slides, then hinges through one place"


def _joints_of(mechanism: Mechanism, body: int) -> list[Joint]:
    """The joints between a body and its parent."""
    return [mechanism.joints[number] for number in joints_of_body(mechanism, body)]


def _refused_parts_of_joint(joint: Joint, solver: SolverName) -> Iterator[tuple[str, str]]:
    """Names the parts of a joint that a solver of Newton, or this builder, cannot express, each
    with a reason."""
    sprung = bool(joint.stiffness) or bool(np.any(joint.damping))
    driven = bool(np.any(joint.armature))
    if joint.kind not in ONE_AXIS and (joint.stiffness or joint.limits or driven):
        yield "spring, limit or armature", f"which is a {joint.kind} joint"
    if joint.kind == "free" and sprung:
        yield "damping", "which is a free joint"
    elif np.ptp(joint.damping):
        yield "damping", "different along its axes"
    if solver == "xpbd" and (sprung or driven):
        yield "spring, damper or armature", "which XPBD does not support"
    if solver != "mujoco" and np.any(joint.friction_loss):
        yield "dry friction", "which only MuJoCo Warp supports"


def _refused_constraints(mechanism: Mechanism, solver: SolverName) -> Iterator[str]:
    """Names the loops and the features of contacts that a solver of Newton, or this builder, cannot
    express."""
    if solver == "featherstone":
        for loop in mechanism.loops:
            yield f"loop {loop.name}, which Featherstone's solver does not support"
        if mechanism.touching:
            yield "contacts, which are springs in Featherstone's solver"
    for touch in mechanism.touching:
        names = names_of(mechanism, touch)
        yield from refused_directions(touch, names)
        if solver == "mujoco" and touch.restitution:
            yield f"restitution of {names}"


def transform(place: Array, attitude: Array | None = None) -> Any:
    """Newton's transform to a place [m], with an attitude, a quaternion, scalar first, or without a
    rotation."""
    turn = warp.quat_identity() if attitude is None else warp.quat(*np.roll(attitude, -1))
    return warp.transform(warp.vec3(*place), turn)


def _add_trees(mechanism: Mechanism, solver: SolverName, builder: Any) -> list[BodyFrame]:
    """Adds the bodies and the joints of a mechanism to Newton's builder; returns the link and the
    frame of each body. A body without a joint is part of its parent's link."""
    body_frames = [(-1, transform(np.zeros(3)))]
    links = dict[int, list[Body]]()  # bodies of each link, in the frame of the link
    roots = list[int]()  # root of each link's tree
    trees = dict[int, list[int]]()  # {root: numbers of the joints of its tree}
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        parent, frame = body_frames[body.parent]
        drawn = frame * transform(body.place, body.attitude)
        joints = _joints_of(mechanism, number)
        if joints:
            link = builder.add_link(lock_inertia=True)
            roots.append(roots[parent] if parent >= 0 else link)
            axes = [
                _axis(mechanism, joint, solver) for joint in joints if joint.kind in ONE_AXIS
            ]
            tree = trees.setdefault(roots[link], [])
            tree.append(_add_joint(builder, joints, axes, parent, link, drawn))
            parent = link
            drawn = transform(np.zeros(3))
        body_frames.append((parent, drawn))
        links.setdefault(parent, []).append(_body_in_link(body, drawn))
    for joint_numbers in trees.values():
        builder.add_articulation(joint_numbers)
    links.pop(-1, None)  # bodies that are part of the world
    for link, parts in links.items():
        _set_inertia(builder, link, parts)
    return body_frames


def _body_in_link(body: Body, frame: Any) -> Body:
    """The body with its centre of mass and its inertia in the frame of its link. `frame` is the
    body's frame on the link, a transform of Newton."""
    turn = rotation(np.roll(np.array(frame.q, float), 1))
    centre = np.array(frame.p, float) + turn @ body.centre
    return replace(body, centre=centre, inertia=turn @ body.inertia @ turn.T)


def _set_inertia(builder: Any, link: int, parts: Sequence[Body]) -> None:
    """Gives a link the mass and the moments of inertia of its parts. They are written to the
    builder's lists, because the builder's function raises moments below 1e-6 kg m^2."""
    mass = sum(part.mass for part in parts)
    centre = np.sum([part.mass * part.centre for part in parts], axis=0) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        arm = part.centre - centre
        inertia += part.inertia + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    builder.body_mass[link] = mass
    builder.body_inv_mass[link] = 1.0 / mass
    builder.body_com[link] = warp.vec3(*centre)
    builder.body_inertia[link] = warp.mat33(inertia)
    builder.body_inv_inertia[link] = warp.mat33(np.linalg.inv(inertia))


def _add_joint(
    builder: Any,
    joints: Sequence[Joint],
    axes: Sequence[Any],
    parent: int,
    link: int,
    drawn: Any,
) -> int:
    """Adds Newton's joint for all joints of a body, whose `axes` are Newton's; returns its number.
    In the drawing, the body of `link` has the frame `drawn` on the link `parent`."""
    first = joints[0]
    if first.kind == "free":
        return int(builder.add_joint_free(link))
    at_joint = transform(first.place)
    frames = {"parent_xform": drawn * at_joint, "child_xform": at_joint}
    if first.kind == "ball":
        damping = float(first.damping[0])
        return int(builder.add_joint_ball(parent, link, damping=damping, **frames))
    slides = sum(joint.kind == "slide" for joint in joints)  # they come before the hinges
    joint_number = builder.add_joint_d6(
        parent, link, linear_axes=axes[:slides], angular_axes=axes[slides:], **frames
    )
    return int(joint_number)


def _axis(mechanism: Mechanism, joint: Joint, solver: SolverName) -> Any:
    """Newton's axis for a hinge or a slide, with its spring, its servos and its limits."""
    reference = float(joint.reference[0])
    armature = float(joint.armature[0])
    servo_stiffness = 0.0
    servo_damping = 0.0
    for motor in mechanism.actuators:
        if mechanism.joints[motor.joint] is joint:
            servo_stiffness -= motor.gear**2 * motor.bias[1]
            servo_damping -= motor.gear**2 * motor.bias[2]
    if joint.velocity is not None:
        armature = _rotor_inertia(mechanism, joint, solver)
        servo_stiffness = RIGID if solver == "xpbd" else 0.0
    limits = {}
    if joint.limits is not None:
        low, high = joint.limits
        limits = {"limit_lower": low - reference, "limit_upper": high - reference}
    return newton.ModelBuilder.JointDofConfig(
        axis=warp.vec3(*joint.axis),
        armature=armature,
        stiffness=joint.stiffness,
        rest_q=float(joint.rest[0]) - reference,
        damping=float(joint.damping[0]),
        friction=float(joint.friction_loss[0]),
        target_q=-reference if servo_stiffness else 0.0,
        target_ke=servo_stiffness,
        target_kd=servo_damping,
        **limits,
    )


def _rotor_inertia(mechanism: Mechanism, joint: Joint, solver: SolverName) -> float:
    """The inertia of the rotor that prescribes a joint's motion [kg m^2] or [kg]; 0 in XPBD, where
    a drive prescribes it."""
    if solver == "xpbd":
        return 0.0
    iterated = solver == "mujoco" and (mechanism.touching or mechanism.loops)
    ratio = HOLDING_BESIDE_CONSTRAINTS if iterated else HOLDING
    return ratio * moved_inertia(mechanism, joint.kind)


def _close_loops(mechanism: Mechanism, body_frames: Sequence[BodyFrame], builder: Any) -> None:
    """Adds joints that close the loops of a mechanism; they belong to no tree."""
    for loop in mechanism.loops:
        (parent, frame), (child, child_frame) = (body_frames[body] for body in loop.bodies)
        place, child_place = loop.places
        turn = None if loop.kind == "connect" else loop.attitude
        frame = frame * transform(place, turn)
        child_frame = child_frame * transform(child_place)
        if child < 0:  # Newton does not accept the world as the child of a joint
            parent, child = child, parent
            frame, child_frame = child_frame, frame
        add = builder.add_joint_ball if loop.kind == "connect" else builder.add_joint_fixed
        add(parent, child, parent_xform=frame, child_xform=child_frame)


def _add_shapes(mechanism: Mechanism, body_frames: Sequence[BodyFrame], builder: Any) -> None:
    """Adds the shapes of a mechanism, and lets only the pairs in `mechanism.touching` collide. A
    pair of Newton's shapes has the mean, or the larger, of the coefficients of its two shapes."""

    def add(number: int, surface: Surface) -> int:
        """Adds the shape with a number and these coefficients."""
        shape = mechanism.shapes[number]
        return _add_shape(builder, body_frames[shape.body], shape, surface)

    pairs = add_shape_copies(mechanism, _surface, add)
    touching = {frozenset(pair) for pair in pairs}
    for first, second in combinations(sorted(set(chain.from_iterable(pairs))), 2):
        if frozenset((first, second)) not in touching:
            builder.add_shape_collision_filter_pair(first, second)


def _surface(touch: Touch) -> Surface:
    """The coefficients of a pair of shapes."""
    return touch.sliding[0], touch.torsional, touch.rolling[0], touch.restitution


def _add_shape(builder: Any, body_frame: BodyFrame, shape: Shape, surface: Surface) -> int:
    """Adds a shape with its coefficients to the link of its body; returns the number of Newton's
    shape."""
    sliding, torsional, rolling, restitution = surface
    config = newton.ModelBuilder.ShapeConfig(
        density=0.0,
        mu=sliding,
        mu_torsional=torsional,
        mu_rolling=rolling,
        restitution=restitution,
    )
    link, frame_on_link = body_frame
    frame = frame_on_link * transform(shape.place, shape.attitude)
    sizes = dict(zip(SIZES[shape.kind], [*shape.size.tolist(), 0.0, 0.0], strict=False))
    # Only MuJoCo Warp reads this attribute. Without it, a pair without friction makes the solver
    # diverge.
    dimensions = {"mujoco:condim": _dimensions(surface)}
    add = getattr(builder, f"add_shape_{shape.kind}")
    return int(add(body=link, xform=frame, cfg=config, custom_attributes=dimensions, **sizes))


def _dimensions(surface: Surface) -> int:
    """The number of dimensions of a contact: 1 without friction, 3 with sliding friction, 4 with
    torsional friction, 6 with rolling friction."""
    sliding, torsional, rolling, _ = surface
    if rolling:
        return 6
    if torsional:
        return 4
    return 3 if sliding else 1
