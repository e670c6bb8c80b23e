"""A mechanism: the bodies, joints, loops, shapes and actuators that an engine is to step.

Engines differ in how they name, order and parametrise these things. A mechanism has them as plain
records in SI units, made from a compiled model or by hand, from which the model of any engine can
be built. Places are those of the drawing, in which each joint has its reference coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.models.idealisations import Idealisations

JointKind = Literal["hinge", "slide", "ball", "free"]
LoopKind = Literal["connect", "weld"]
ShapeKind = Literal["sphere", "capsule", "box", "cylinder", "ellipsoid", "plane", "hull"]

# [s] times at which a prescribed velocity is evaluated to see whether it is constant
ASKED_AT = np.concatenate(
    [np.linspace(0.0, 1.0, 1000, endpoint=False), np.geomspace(1.0, 1e3, 500)]
)


@dataclass(frozen=True)
class Body:
    """A rigid body. A body without a joint is welded to its parent."""

    name: str  # empty where it has none
    parent: int  # number of the body that carries it, smaller than its own number
    place: Array  # origin of the body's frame in the parent's frame [m], shape (3,)
    # attitude of the body's frame in the parent's frame, a quaternion, scalar first
    attitude: Array
    mass: float  # [kg]
    centre: Array  # centre of mass in the body's frame [m], shape (3,)
    inertia: Array  # about its centre, along the axes of its frame [kg m^2], shape (3, 3)
    carried: float = 0.0  # fraction of its weight that a constant upward force balances
    # Whether it stands for a point mass: MuJoCo accepts no body without moments of inertia
    point: bool = False


@dataclass(frozen=True)
class Joint:
    """A joint between a body and its parent. Several joints of one body act in the order of the
    list: each is fixed in the frame that the joints before it have moved.

    A hinge turns about `axis` through `place`, a slide moves along `axis`, a ball turns about
    `place`. A free body has no place: its coordinates are its frame's place and attitude.
    """

    name: str  # empty where it has none
    kind: JointKind
    body: int  # number of the body that it moves
    axis: Array  # in the body's frame, unit length, shape (3,)
    place: Array  # in the body's frame [m], shape (3,)
    # Coordinates in the reference pose, which is the pose that the model file draws: [rad], [m], or
    # a quaternion, scalar first
    reference: Array
    stiffness: float  # [N m/rad] or [N/m]
    rest: Array  # coordinates at which the spring has no force, shaped as `reference`
    damping: Array  # [N m s/rad] or [N s/m], one number a degree of freedom
    armature: Array  # inertia added to each degree of freedom [kg m^2] or [kg]
    friction_loss: Array  # largest dry friction of each degree of freedom [N m] or [N]
    # smallest and largest coordinate; a ball joint's limits bound its angle of rotation
    limits: tuple[float, float] | None
    # smallest and largest force of all actuators of the joint together [N m] or [N]
    force_range: tuple[float, float] | None
    velocity: Callable[[Array], Array] | None = None
    """The velocity [rad/s] or [m/s] at times [s], shape (n,) each, if the joint's motion is
    prescribed whatever forces act."""


@dataclass(frozen=True)
class Loop:
    """A constraint that closes a loop: two points of two bodies coincide ("connect"), or two
    frames ("weld")."""

    name: str  # empty where it has none
    kind: LoopKind
    bodies: tuple[int, int]
    places: tuple[Array, Array]  # in the frame of each body [m], shape (3,) each
    # weld: attitude of the second body's frame in the first body's frame, scalar first
    attitude: Array


@dataclass(frozen=True)
class Shape:
    """A shape of a body, which may touch another."""

    name: str  # empty where it has none
    kind: ShapeKind
    body: int
    place: Array  # origin of the shape's frame in the body's frame [m], shape (3,)
    attitude: Array  # attitude of the shape's frame in the body's frame, scalar first
    # Radius; radius and half length; or half sizes [m]. A plane and a hull have none. The normal of
    # a plane is its z axis.
    size: Array


@dataclass(frozen=True)
class Touch:
    """Two shapes that can touch, and the friction between them."""

    shapes: tuple[int, int]
    sliding: tuple[float, float]  # coefficients along two tangents
    torsional: float  # [m]
    rolling: tuple[float, float]  # [m]
    restitution: float = 0.0  # ratio of normal speeds after and before an impact


@dataclass(frozen=True)
class Actuator:
    """A force on a hinge or a slide: gear times force, where

        force = gain u + bias[0] + bias[1] gear q + bias[2] gear q'

    of a control u, within the range of forces."""

    name: str  # empty where it has none
    joint: int
    control: int  # number of its control
    gear: float
    gain: float
    bias: tuple[float, float, float]
    control_range: tuple[float, float] | None
    force_range: tuple[float, float] | None  # force before the gear multiplies it

    @property
    def biased(self) -> bool:
        """Whether a part of its force does not depend on its control."""
        return any(self.bias)


@dataclass(frozen=True)
class NotExpressed:
    """A part of a model for which a mechanism has no record."""

    name: str  # "tendon hamstring"


@dataclass(frozen=True)
class Mechanism:
    """A whole mechanism. Body 0 is the world, in whose frame gravity is given."""

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    loops: tuple[Loop, ...]
    shapes: tuple[Shape, ...]
    touching: tuple[Touch, ...]
    actuators: tuple[Actuator, ...]
    gravity: Array  # [m/s^2], shape (3,)
    not_expressed: tuple[NotExpressed, ...] = ()


def is_constant(velocity: Callable[[Array], Array]) -> bool:
    """Whether a prescribed velocity is the same at all times of `ASKED_AT`."""
    return not np.ptp(velocity(ASKED_AT))


def idealised(mechanism: Mechanism, ideal: Idealisations) -> Mechanism:
    """The mechanism with a system's idealisations in place of the model file's approximations of
    them. A joint whose motion is prescribed loses its armature and its actuators, by which the file
    imposes that motion. Raises KeyError if a name is not in the mechanism."""
    joint_names = [joint.name for joint in mechanism.joints]
    _require(set(joint_names), ideal.velocities)
    _require({loop.name for loop in mechanism.loops}, ideal.rigid_loops)
    _require({body.name for body in mechanism.bodies}, ideal.points)
    _require({shape.name for shape in mechanism.shapes}, ideal.restitution)
    return replace(
        mechanism,
        bodies=tuple(
            replace(body, point=body.name in ideal.points) for body in mechanism.bodies
        ),
        joints=tuple(_prescribed(joint, ideal) for joint in mechanism.joints),
        touching=tuple(_bouncing(mechanism, touch, ideal) for touch in mechanism.touching),
        actuators=tuple(
            actuator
            for actuator in mechanism.actuators
            if joint_names[actuator.joint] not in ideal.velocities
        ),
    )


def _require(known: set[str], names: Iterable[str]) -> None:
    """Raises KeyError if one of the `names` is not `known`."""
    if missing := sorted(set(names) - known):
        raise KeyError(f"{missing[0]} is not one of {', '.join(sorted(known))}")


def _prescribed(joint: Joint, ideal: Idealisations) -> Joint:
    """A joint with the velocity that the system prescribes for it, if any."""
    velocity = ideal.velocities.get(joint.name)
    if velocity is None:
        return joint
    return replace(joint, velocity=velocity, armature=np.zeros_like(joint.armature))


def _bouncing(mechanism: Mechanism, touch: Touch, ideal: Idealisations) -> Touch:
    """A pair of shapes with the larger restitution that the system states for either of them."""
    names = (mechanism.shapes[number].name for number in touch.shapes)
    return replace(touch, restitution=max(ideal.restitution.get(name, 0.0) for name in names))
