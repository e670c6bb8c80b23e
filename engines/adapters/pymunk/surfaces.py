"""Shapes that touch, in pymunk: circles, boxes, and floors made of thick lines."""

from __future__ import annotations

import cmath
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
import pymunk

from plumbob.analytic.errors.contact_models.impacts import ALLOWED_PENETRATION
from plumbob.analytic.errors.contact_models.rod_steps import ROD_END_RADIUS
from plumbob.engines.adapters.pymunk.links import WORLD, Links, Pose
from plumbob.engines.adapters.pymunk.methods import FLOOR_TIME
from plumbob.engines.adapters.pymunk.plane import CLOSE
from plumbob.engines.adapters.pymunk.simulation import vector
from plumbob.engines.mechanism import Mechanism, Shape, Touch
from plumbob.engines.method import Unsupported
from plumbob.engines.peer_model import rotation
from plumbob.engines.stepper import State

# Overlap at the start of shapes that touch, as a fraction of their size; half of it if one of them
# is a circle. Without an overlap rounding would decide whether they touch.
DEPTH = 1e-6
TOUCHING = 1e-9  # largest gap of shapes that touch, as a fraction of their size
# Largest radius of a circle that stands for a point, relative to its distance from the centre of
# mass
POINT = 1e-6
# Depth and length to either side of a floor below a point, in sizes of the point's surface. It is
# so deep that no step passes the floor.
DEEP = 1e2
BITS = 32  # number of bits of pymunk's masks
AXES = (1 + 0j, -1 + 0j, 1j, -1j)


@dataclass(frozen=True)
class Surface:
    """A circle or a box in the plane, or a floor."""

    link: int  # number of its link, or WORLD
    place: complex  # its middle from the link's centre, or a point of a floor [m]
    radius: float  # radius of a circle; 0 for a box or a floor [m]
    # length that tolerances scale with: a circle's radius, a box's longest edge [m]
    size: float
    # half width (real) and half height (imaginary) of a box, in its link's axes
    half: complex = 0j
    normal: complex = 0j  # normal of a floor, pointing away from the floor
    point: bool = False  # whether a circle stands for a point

    def smallest_coordinate(self, poses: Sequence[Pose], direction: complex) -> float:
        """The smallest coordinate of the surface along `direction`, a unit vector of the plane [m].
        `poses` has the poses of all links."""
        place = self.place
        direction_in_link = direction
        if self.link != WORLD:
            place, _ = poses[self.link].at(place)
            direction_in_link *= cmath.exp(-1j * poses[self.link].angle)
        extent = abs(self.half.real * direction_in_link.real)
        extent += abs(self.half.imag * direction_in_link.imag)
        return (place * direction.conjugate()).real - self.radius - extent


@dataclass(frozen=True)
class Pair:
    """Two surfaces that may touch."""

    surfaces: tuple[int, int]
    friction: float
    restitution: float
    touches: bool  # whether they touch at the start

    def set_coefficients(
        self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object
    ) -> None:
        """Sets the friction and the restitution of a contact of the pair. pymunk's other arguments
        have no effect."""
        arbiter.friction = self.friction
        arbiter.restitution = self.restitution


@dataclass(frozen=True)
class Surfaces:
    """The surfaces of a mechanism, and the pairs of them that may touch."""

    all: tuple[Surface, ...]
    pairs: tuple[Pair, ...]
    friction: tuple[float, ...]  # friction of each surface: pymunk multiplies those of a pair
    restitution: tuple[float, ...]  # restitution of each surface: pymunk multiplies them, too
    skin: float  # thickness added to floors and boxes [m]
    slop: float  # overlap that pymunk does not correct [m]
    reach: float  # length of a floor to either side [m]

    def links(self, pair: Pair) -> tuple[int, int]:
        """The links of a pair's surfaces."""
        first, second = pair.surfaces
        return self.all[first].link, self.all[second].link

    @property
    def piled(self) -> set[int]:
        """The links that touch one another at the start."""
        piled = set[int]()
        for pair in self.pairs:
            links = self.links(pair)
            if pair.touches and WORLD not in links:
                piled.update(links)
        return piled

    def add(self, space: pymunk.Space, bodies: Sequence[pymunk.Body]) -> list[pymunk.Shape]:
        """Adds shapes to the space, on the bodies of the links and on the static body; returns
        them."""
        shapes = list[pymunk.Shape]()
        for number, surface in enumerate(self.all):
            body = space.static_body if surface.link == WORLD else bodies[surface.link]
            shape = self._shape(surface, body)
            shape.filter = pymunk.ShapeFilter(_category(number), self._mask(number))
            shape.collision_type = number
            shape.friction = self.friction[number]
            shape.elasticity = self.restitution[number]
            shapes.append(shape)
        for pair in self.pairs:
            first, second = pair.surfaces
            product = self.friction[first] * self.friction[second]
            bounce = self.restitution[first] * self.restitution[second]
            if (product, bounce) != (pair.friction, pair.restitution):
                space.on_collision(first, second, pre_solve=pair.set_coefficients)
        space.add(*shapes)
        space.collision_slop = self.slop
        return shapes

    def _mask(self, number: int) -> int:
        """The categories of the surfaces that the surface with this number may touch."""
        mask = 0
        for pair in self.pairs:
            if number in pair.surfaces:
                (other,) = set(pair.surfaces) - {number}
                mask |= _category(other)
        return mask

    def _shape(self, surface: Surface, body: pymunk.Body) -> pymunk.Shape:
        """The shape of a surface on a body."""
        place = surface.place
        if surface.half:
            # The box is made by pymunk: impulses are kept for the next step by the numbers of
            # corners, and with polygons of a caller pymunk confuses the two contacts of two boxes,
            # so that stacks collapse. The box has no radius: if boxes overlapped by their radii
            # alone, rounding would decide the direction of a contact.
            corner = surface.half + complex(self.skin, self.skin)
            box = pymunk.BB(*vector(place - corner), *vector(place + corner))
            return pymunk.Poly.create_box_bb(body, box)
        if not surface.normal:
            return pymunk.Circle(body, surface.radius, vector(place))
        thickness = self.skin
        reach = self.reach
        depth = DEEP * max((other.size for other in self.all if other.point), default=0.0)
        if depth:
            place -= depth * surface.normal
            thickness = reach = depth
        along = -1j * reach * surface.normal
        return pymunk.Segment(body, vector(place - along), vector(place + along), thickness)


def _category(number: int) -> int:
    """The bit of pymunk's masks that stands for the surface with this number."""
    return 1 << number % BITS


def surfaces_of(mechanism: Mechanism, links: Links, start: State) -> Surfaces:
    """The surfaces of a mechanism that starts in a state; raises Unsupported."""
    surfaces = tuple(_surface(mechanism, links, shape) for shape in mechanism.shapes)
    poses = links.poses(start)
    gaps = [
        _gap(poses, *(surfaces[number] for number in touch.shapes))
        for touch in mechanism.touching
    ]
    size = max((surface.size for surface in surfaces), default=0.0)
    pairs = tuple(
        Pair(
            touch.shapes,
            _sliding(mechanism, links, touch),
            touch.restitution,
            gap < TOUCHING * size,
        )
        for touch, gap in zip(mechanism.touching, gaps, strict=True)
    )
    skin = 0.0
    if any(surface.point for surface in surfaces):
        # The slop is so large that pymunk never pushes a point out of a floor.
        slop = DEEP * size
    elif any(pair.touches for pair in pairs):
        # Shapes that touch at the start overlap by a depth that pymunk does not correct.
        skin = DEPTH * size / 2.0
        slop = 2.0 * DEPTH * size
    else:
        # The slop of a body that falls onto another is proportional to the height of its fall.
        slop = ALLOWED_PENETRATION * max(gaps, default=0.0)
    touching_first = sorted(pairs, key=lambda pair: not pair.touches)
    frictions = {pair.surfaces: pair.friction for pair in touching_first}
    restitutions = {pair.surfaces: pair.restitution for pair in touching_first}
    return Surfaces(
        all=surfaces,
        pairs=pairs,
        friction=_factors(len(surfaces), frictions),
        restitution=_factors(len(surfaces), restitutions),
        skin=skin,
        slop=slop,
        reach=_reach(mechanism, links, start, surfaces, size),
    )


def _surface(mechanism: Mechanism, links: Links, shape: Shape) -> Surface:
    """The surface of a shape in the plane; raises Unsupported."""
    plane = links.plane
    link, place = links.arm(shape.body, shape.place)
    axes = links.drawn.turns[shape.body] @ rotation(shape.attitude)
    if shape.kind == "plane" and shape.body == 0:
        return Surface(WORLD, place, 0.0, 0.0, normal=plane.flat(axes[:, 2]))
    if shape.kind == "sphere":
        radius = float(shape.size[0])
        if radius < POINT * abs(place):
            length = 2.0 * abs(place)
            return Surface(link, place, ROD_END_RADIUS * length, length, point=True)
        return Surface(link, place, radius, radius)
    name = shape.name or mechanism.bodies[shape.body].name
    if shape.kind != "box":
        raise Unsupported(f"pymunk has no {shape.kind} that touches: {name}")
    # Cosines of the angles between the directions of the plane and the axes of the box
    leans = np.abs(np.array([plane.right, plane.up]) @ axes)
    if leans.max() < 1.0 - CLOSE:
        raise Unsupported(f"pymunk has no box that leans in the drawing: {name}")
    # A box may lie on one of its edges: its extent in the plane reaches to its faces.
    right, up = (
        min(half / lean for half, lean in zip(shape.size, row, strict=True) if lean > CLOSE)
        for row in leans
    )
    longest_edge = 2.0 * float(shape.size.max())
    return Surface(link, place, 0.0, longest_edge, half=complex(right, up))


def _gap(poses: Sequence[Pose], first: Surface, second: Surface) -> float:
    """The gap between two surfaces [m], or between their axis-aligned bounding boxes if neither is
    a floor; negative if they overlap."""
    directions: Sequence[complex] = AXES
    if first.normal or second.normal:
        directions = [first.normal or -second.normal]
    return max(
        first.smallest_coordinate(poses, -direction)
        + second.smallest_coordinate(poses, direction)
        for direction in directions
    )


def _sliding(mechanism: Mechanism, links: Links, touch: Touch) -> float:
    """The coefficient of friction of a pair in the plane; raises Unsupported."""
    if any(touch.rolling):
        raise Unsupported("pymunk has no rolling friction")
    if touch.sliding[0] != touch.sliding[1]:
        raise Unsupported("pymunk has no friction that depends on the direction")
    first, second = (mechanism.shapes[number] for number in touch.shapes)
    points = [links.drawn.point(shape.body, shape.place) for shape in (first, second)]
    offset = points[1] - points[0]
    bounded = "plane" not in (first.kind, second.kind)
    if bounded and abs(links.plane.across(offset)) > CLOSE * np.linalg.norm(offset):
        raise Unsupported(
            f"pymunk has no shapes beside one another: {first.name}, {second.name}"
        )
    return touch.sliding[0]


def _factors(count: int, products: Mapping[tuple[int, int], float]) -> tuple[float, ...]:
    """A factor for each of `count` surfaces, such that the factors of each pair have the wanted
    product. If that is not possible for all pairs, the first pairs have their products. In a pair
    whose factors are both unknown, the surface that is in more pairs has the factor 1."""
    number_of_pairs = Counter(chain.from_iterable(products))
    factors = dict[int, float]()
    for pair, product in products.items():
        first, second = pair if pair[0] in factors else pair[::-1]
        if first not in factors:
            first, second = sorted(pair, key=lambda surface: -number_of_pairs[surface])
        first_factor = factors.setdefault(first, 1.0)
        factors.setdefault(second, product / first_factor if first_factor else 1.0)
    return tuple(factors.get(number, 1.0) for number in range(count))


def _reach(
    mechanism: Mechanism, links: Links, start: State, surfaces: Sequence[Surface], size: float
) -> float:
    """The length of a floor to either side [m], beyond which no body gets within FLOOR_TIME."""
    turns = [joint.kind == "hinge" for joint in mechanism.joints]
    speed = float(np.sum(np.abs(start.qvel) * np.where(turns, size, 1.0)))
    gravity = links.plane.flat(mechanism.gravity)
    accelerations_along_floors = [
        abs((gravity * surface.normal.conjugate()).imag)
        for surface in surfaces
        if surface.normal
    ]
    acceleration = max(accelerations_along_floors, default=0.0)
    return FLOOR_TIME * speed + 0.5 * acceleration * FLOOR_TIME**2 + size
