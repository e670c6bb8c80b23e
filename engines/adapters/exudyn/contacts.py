"""Contacts of shapes with a plane in Exudyn. They are springs and dampers, and each contact has a
coefficient of friction.

The only contact of Exudyn that slides and rolls well is the contact of a disc. These shapes are
discs: a flat ellipsoid; a sphere whose body turns about one axis that is parallel to the plane; and
a point, which is a corner of a box or a sphere with a tiny radius. The disc of a point may have any
axis that is parallel to the plane.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import exudyn
import exudyn.itemInterface
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.exudyn.bodies import (
    AXES,
    PARALLEL,
    moving_joints,
    norm,
)
from plumbob.engines.adapters.reference_pose import ReferencePose, reference_pose
from plumbob.engines.adapters.refusals import names_of, refused_friction, refused_shapes
from plumbob.engines.mechanism import Mechanism, Shape, Touch
from plumbob.engines.peer_model import rotation

items = exudyn.itemInterface

# Rate of a contact times the step. The contact carries the mass of all bodies and is critically
# damped: at 1 ms its static penetration under their weight is 10 micrometres.
RATE = 1.0
BOUNCE = 20.0  # number of steps that an impact with restitution lasts
# [m/s^2] speed below which friction is proportional to the slip, divided by the step. It is larger
# than the slip speed that gravity causes within a step on a slope: otherwise the solver would take
# a sticking body for a slipping body.
SLIP = 5.0
# [m] largest radius of a sphere that is taken for a point: a tilt displaces its contact by less
POINT = 1e-4
CORNER = 1e-3  # radius of the disc in a corner of a box, relative to the smallest half size
FLAT = 1e-3  # largest thickness of a disc, relative to its diameter
# [m] gap before the first step: it lets Exudyn see a first touch as an impact
INITIAL_GAP = 1.0
# A triangle that stands for a plane below a bouncing sphere: its corners [m]. The distance from the
# middle of the plane to the nearest side is 100 m.
TRIANGLE = 100.0 * np.array([[-2.0, -1.0, 0.0], [2.0, -1.0, 0.0], [0.0, 2.0, 0.0]])
ROUNDING = 2.0 * sys.float_info.epsilon  # [m] rounding of the depths of contacts
Mark = Callable[[Shape, Array], int]
"""Adds a marker at a place [m] in the frame of a shape; returns its number."""
Disc = tuple[Array, float, Array]
"""The place of a disc's centre [m], its radius [m] and its axis, in the frame of a shape."""


def refused_contacts(mechanism: Mechanism) -> Iterator[str]:
    """Names the shapes and the features of contacts that Exudyn, or this builder, cannot
    express."""
    yield from refused_shapes(mechanism)
    for touch in mechanism.touching:
        plane, other = _plane_first(mechanism, touch)
        names = names_of(mechanism, touch)
        yield from refused_friction(touch, names)
        if touch.restitution:
            if plane.kind != "plane" or other.kind != "sphere" or touch.sliding[0]:
                yield f"restitution of {names}, which needs a sphere on a plane without friction"
        elif not _discs(mechanism, plane, other):
            yield f"contact of {names}"


def _plane_first(mechanism: Mechanism, touch: Touch) -> tuple[Shape, Shape]:
    """The two shapes that can touch. If the second shape is a plane, it comes first."""
    first, second = (mechanism.shapes[number] for number in touch.shapes)
    return (second, first) if second.kind == "plane" else (first, second)


def _discs(mechanism: Mechanism, plane: Shape, other: Shape) -> list[Disc]:
    """The discs that stand for the shape `other` in its contact with a plane. Empty if the builder
    cannot express the contact."""
    if plane.kind != "plane":
        return []
    middle = np.zeros(3)
    if other.kind == "ellipsoid":
        least, between, most = np.sort(other.size).tolist()
        flat = between == most and least <= FLAT * most
        return [(middle, most, AXES[np.argmin(other.size)])] if flat else []
    pose = reference_pose(mechanism)
    normal = pose.turns[plane.body] @ rotation(plane.attitude)[:, 2]
    turn = (pose.turns[other.body] @ rotation(other.attitude)).T
    direction = _direction_in_plane(normal)
    any_axis = turn @ direction / norm(direction)
    if other.kind == "box":
        radius = CORNER * float(other.size.min())
        places = np.array(list(product((-1, 1), repeat=3))) * (other.size - radius)
        return [(place, radius, any_axis) for place in places]
    if other.kind == "sphere" and other.size[0] > POINT:
        axis = _only_axis(mechanism, pose, other.body, normal)
        return [] if axis is None else [(middle, float(other.size[0]), turn @ axis)]
    if other.kind == "sphere":
        return [(middle, float(other.size[0]), any_axis)]
    return []


def _only_axis(
    mechanism: Mechanism, pose: ReferencePose, body: int, normal: Array
) -> Array | None:
    """The direction in the world of the only axis about which a body can turn, if that axis is
    parallel to a plane with this normal. If the body cannot turn, any direction in the plane; None
    if it can turn about other axes, too. `pose` is the reference pose."""
    turning = [joint for joint in moving_joints(mechanism, body) if joint.kind != "slide"]
    if any(joint.kind != "hinge" for joint in turning):
        return None
    axes = [pose.axis(joint) for joint in turning]
    axis = axes[0] if axes else _direction_in_plane(normal)
    out_of_plane = abs(float(axis @ normal))
    misalignments = [norm(np.cross(other, axis)) for other in axes]
    return axis / norm(axis) if max([out_of_plane, *misalignments]) <= PARALLEL else None


def _direction_in_plane(normal: Array) -> Array:
    """A direction parallel to a plane with this normal."""
    return np.cross(normal, AXES[np.argmin(np.abs(normal))])


def rounding_of_forces(mechanism: Mechanism, step: float) -> float:
    """The rounding error of contact forces at a time step [s], as an absolute tolerance [N]."""
    mass = sum(body.mass for body in mechanism.bodies)
    return ROUNDING * mass * (RATE / step) ** 2


@dataclass(frozen=True)
class Contacts:
    """Adds contacts of a mechanism to an Exudyn system."""

    system: Any
    mechanism: Mechanism
    step: float  # [s]
    mark: Mark  # adds markers to the system

    def add(self, touch: Touch) -> None:
        """Adds the contact of two shapes."""
        plane, other = _plane_first(self.mechanism, touch)
        if touch.restitution:
            self._add_bouncing(plane, other, touch.restitution)
        else:
            for disc in _discs(self.mechanism, plane, other):
                self._add_rolling(plane, other, disc, touch)

    @property
    def _law(self) -> tuple[float, float]:
        """The stiffness [N/m] and the damping [N s/m] of a contact."""
        rate = RATE / self.step
        return self._mass * rate**2, 2.0 * self._mass * rate

    @property
    def _mass(self) -> float:
        """The mass of all bodies [kg]."""
        return sum(body.mass for body in self.mechanism.bodies)

    def _add_rolling(self, plane: Shape, other: Shape, disc: Disc, touch: Touch) -> None:
        """Adds a contact between a plane and the rim of a disc of the shape `other`."""
        place, radius, axis = disc
        stiffness, damping = self._law
        self.system.AddObject(
            items.ObjectConnectorRollingDiscPenalty(
                markerNumbers=[self.mark(plane, np.zeros(3)), self.mark(other, place)],
                nodeNumber=self._add_data(0.0, 0.0, 0.0),
                discRadius=radius,
                discAxis=axis,
                planeNormal=AXES[2],
                contactStiffness=stiffness,
                contactDamping=damping,
                dryFriction=list(touch.sliding),
                dryFrictionProportionalZone=SLIP * self.step,
                useLinearProportionalZone=True,
            )
        )

    def _add_bouncing(self, plane: Shape, ball: Shape, restitution: float) -> None:
        """Adds a contact between a plane and a sphere that bounces with a coefficient of
        restitution."""
        self.system.AddObject(
            items.ObjectContactSphereTriangle(
                markerNumbers=[self.mark(shape, np.zeros(3)) for shape in (ball, plane)],
                nodeNumber=self._add_data(INITIAL_GAP, 0.0, 0.0, 0.0),
                sphereRadius=float(ball.size[0]),
                trianglePoints=exudyn.Vector3DList(list(TRIANGLE)),
                includeEdges=0,
                contactStiffness=self._mass * (math.pi / (BOUNCE * self.step)) ** 2,
                restitutionCoefficient=restitution,
                impactModel=2,
            )
        )

    def _add_data(self, *values: float) -> int:
        """Adds a node for the numbers that a contact keeps from step to step, with their initial
        values; returns the number of the node."""
        node = items.NodeGenericData(
            initialCoordinates=list(values), numberOfDataCoordinates=len(values)
        )
        return int(self.system.AddNode(node))
