"""Shapes that touch, as pymunk has them: circles, boxes, and floors of thick lines."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pymunk

from plumbob.analytic.errors.contact_models.impacts import SLOP
from plumbob.analytic.errors.contact_models.rod_steps import TIP
from plumbob.engines.adapters.pymunk.links import WORLD, Links, Pose
from plumbob.engines.adapters.pymunk.methods import FLOOR_TIME
from plumbob.engines.adapters.pymunk.plane import CLOSE
from plumbob.engines.adapters.pymunk.simulation import vector
from plumbob.engines.mechanism import Mechanism, Shape, Touch
from plumbob.engines.method import Unsupported
from plumbob.engines.peer_model import rotation
from plumbob.engines.stepper import State

# Of a size: shapes that touch at the start overlap by as much, or by half of it where one of them
# is a circle, or they would touch by rounding alone.
DEPTH = 1e-6
TOUCHING = 1e-9  # of a size: shapes that are closer touch, since positions are rounded
# Of its distance from the centre of mass: the radius of a circle that is meant as a point.
POINT = 1e-6
# Lengths that a floor below a point extends to either side and down, so that no step passes it.
DEEP = 1e2
BITS = 32  # of pymunk's masks


@dataclass(frozen=True)
class Surface:
    """A shape in the plane: points with a radius about them, or a floor."""

    link: int  # or WORLD
    points: tuple[complex, ...]  # from the link's centre, or on the floor [m]
    radius: float  # [m]
    size: float  # [m], the radius of a circle or the longest edge of a box
    normal: complex = 0j  # of a floor, away from it
    point: bool = False  # a circle so small that a point is meant

    def placed(self, poses: Sequence[Pose]) -> Surface:
        """The same surface with its points in the plane."""
        if self.link == WORLD:
            return self
        points = tuple(poses[self.link].at(arm)[0] for arm in self.points)
        return Surface(WORLD, points, self.radius, self.size)


@dataclass(frozen=True)
class Pair:
    """Two surfaces that may touch."""

    surfaces: tuple[int, int]
    friction: float
    restitution: float
    touches: bool  # at the start

    def rub(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        """Give a contact of the pair its friction and restitution."""
        arbiter.friction = self.friction
        arbiter.restitution = self.restitution


@dataclass(frozen=True)
class Surfaces:
    """The surfaces of a mechanism, which pairs of them touch, and how."""

    all: tuple[Surface, ...]
    pairs: tuple[Pair, ...]
    friction: tuple[float, ...]  # of each surface: pymunk gives a pair their product
    restitution: tuple[float, ...]  # likewise
    skin: float  # by which floors and boxes are thicker [m], the shorter edge of a box by less
    slop: float  # depth that is not closed [m]
    reach: float  # of a floor to either side [m]

    def links(self, pair: Pair) -> tuple[int, int]:
        """The links of a pair's surfaces."""
        first, second = pair.surfaces
        return self.all[first].link, self.all[second].link

    @property
    def piled(self) -> set[int]:
        """The links that touch one another at the start."""
        links = [self.links(pair) for pair in self.pairs if pair.touches]
        return {link for both in links for link in both if WORLD not in both}

    def add(self, space: pymunk.Space, bodies: Sequence[pymunk.Body]) -> list[pymunk.Shape]:
        """Shapes of pymunk on the bodies of the links and on the space's own, in the space."""
        made = list[pymunk.Shape]()
        for number, surface in enumerate(self.all):
            body = space.static_body if surface.link == WORLD else bodies[surface.link]
            shape = self._shape(surface, body)
            pairs = [pair.surfaces for pair in self.pairs if number in pair.surfaces]
            mask = sum({1 << p % BITS for pair in pairs for p in pair if p != number})
            shape.filter = pymunk.ShapeFilter(categories=1 << number % BITS, mask=mask)
            shape.collision_type = number
            shape.friction = self.friction[number]
            shape.elasticity = self.restitution[number]
            made.append(shape)
        for pair in self.pairs:
            first, second = pair.surfaces
            product = self.friction[first] * self.friction[second]
            bounce = self.restitution[first] * self.restitution[second]
            if (product, bounce) != (pair.friction, pair.restitution):
                space.on_collision(first, second, pre_solve=pair.rub)
        space.add(*made)
        space.collision_slop = self.slop
        return made

    def _shape(self, surface: Surface, body: pymunk.Body) -> pymunk.Shape:
        if len(surface.points) > 1:
            middle = sum(surface.points) / len(surface.points)
            # Not by a radius: polygons that overlap by their radii alone have contacts in a
            # direction that rounding decides.
            grown = 1.0 + 2.0 * self.skin / surface.size
            corners = [middle + grown * (point - middle) for point in surface.points]
            return _polygon(body, corners)
        (place,) = surface.points
        if not surface.normal:
            return pymunk.Circle(body, surface.radius, vector(place))
        thickness = self.skin
        reach = self.reach
        if depth := DEEP * max((s.size for s in self.all if s.point), default=0.0):
            place -= depth * surface.normal
            thickness = reach = depth
        along = -1j * reach * surface.normal
        return pymunk.Segment(body, vector(place - along), vector(place + along), thickness)


def surfaces_of(mechanism: Mechanism, links: Links, start: State) -> Surfaces:
    """The surfaces of a mechanism that starts in a state; raises Unsupported."""
    found = tuple(_surface(mechanism, links, shape) for shape in mechanism.shapes)
    placed = [surface.placed(links.poses(start)) for surface in found]
    gaps = [_gap(*(placed[number] for number in t.shapes)) for t in mechanism.touching]
    size = max((surface.size for surface in found), default=0.0)
    pairs = tuple(
        Pair(touch.shapes, _sliding(touch), touch.restitution, gap < TOUCHING * size)
        for touch, gap in zip(mechanism.touching, gaps, strict=True)
    )
    skin = 0.0
    slop = SLOP * max(gaps, default=0.0)
    if any(surface.point for surface in found):
        slop = DEEP * size  # no depth is closed beside the steps
    elif any(pair.touches for pair in pairs):
        skin = DEPTH * size / 2.0
        slop = 2.0 * DEPTH * size
    nearest = sorted(pairs, key=lambda pair: not pair.touches)
    return Surfaces(
        found,
        pairs,
        _factors(len(found), {pair.surfaces: pair.friction for pair in nearest}),
        _factors(len(found), {pair.surfaces: pair.restitution for pair in nearest}),
        skin,
        slop,
        _reach(mechanism, links, start, found, size),
    )


def _surface(mechanism: Mechanism, links: Links, shape: Shape) -> Surface:
    """A shape in the plane."""
    plane = links.plane
    link, place = links.arm(shape.body, shape.place)
    axes = links.drawn.turns[shape.body] @ rotation(shape.attitude)
    if shape.kind == "plane" and shape.body == 0:
        return Surface(WORLD, (place,), 0.0, 0.0, plane.flat(axes[:, 2]))
    if shape.kind == "sphere":
        radius = float(shape.size[0])
        if radius < POINT * abs(place):
            length = 2.0 * abs(place)
            return Surface(link, (place,), TIP * length, length, point=True)
        return Surface(link, (place,), radius, radius)
    if shape.kind == "box":
        return Surface(
            link, _corners(links, axes, shape, place), 0.0, 2.0 * float(shape.size.max())
        )
    name = mechanism.bodies[shape.body].name
    raise Unsupported(f"pymunk has no {shape.kind} that touches: {shape.name or name}")


def _corners(
    links: Links, axes: np.ndarray, shape: Shape, place: complex
) -> tuple[complex, ...]:
    """The corners of a box's section in the plane; raises Unsupported if no axis of the box is in
    the plane."""
    across = [abs(links.plane.across(axis)) for axis in axes.T]
    along = int(np.argmin(across))
    if across[along] > CLOSE:
        raise Unsupported(f"pymunk has no box that leans out of the plane: {shape.name}")
    first = links.plane.flat(axes[:, along])
    second = 1j * first
    leans = np.abs(links.plane.lifted(second) @ np.delete(axes, along, axis=1))
    width = float(shape.size[along])
    height = min(
        half / lean
        for half, lean in zip(np.delete(shape.size, along), leans, strict=True)
        if lean
    )
    sides = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    return tuple(place + a * width * first + b * height * second for a, b in sides)


def _polygon(body: pymunk.Body, corners: Sequence[complex]) -> pymunk.Shape:
    """A polygon with these corners [m]; pymunk's own box if its edges are those of the axes.

    pymunk keeps the impulses of a step for the next by the numbers of corners. It numbers those of
    a polygon of its caller's from another corner than those of a box, and then takes the one
    contact of two boxes for the other: stacks collapse.
    """
    left, right = (choose(corner.real for corner in corners) for choose in (min, max))
    bottom, top = (choose(corner.imag for corner in corners) for choose in (min, max))
    limits = complex(left, bottom), complex(right, top)
    close = CLOSE * abs(limits[1] - limits[0])
    if all(min(abs(corner - limit) for limit in limits) < close for corner in corners[::2]):
        return pymunk.Poly.create_box_bb(body, pymunk.BB(left, bottom, right, top))
    return pymunk.Poly(body, [vector(corner) for corner in corners])


def _gap(first: Surface, second: Surface) -> float:
    """The gap [m] between two surfaces in the plane, which is negative where they overlap."""
    if second.normal:
        first, second = second, first
    if first.normal:
        return _lowest(second, first.normal) - _lowest(first, first.normal)
    sides = [b - a for s in (first, second) for a, b in itertools.pairwise(s.points)]
    middles = [sum(surface.points) / len(surface.points) for surface in (first, second)]
    normals = [-1j * side for side in sides] or [middles[1] - middles[0]]
    return max(
        _lowest(second, sign * normal) + _lowest(first, -sign * normal)
        for normal in normals
        for sign in (1.0, -1.0)
    )


def _lowest(surface: Surface, direction: complex) -> float:
    """How far along a direction a surface begins [m]."""
    along = direction.conjugate() / abs(direction)
    return min((point * along).real for point in surface.points) - surface.radius


def _sliding(touch: Touch) -> float:
    """The coefficient of friction in the plane; raises Unsupported."""
    if any(touch.rolling):
        raise Unsupported("pymunk has no rolling friction")
    if touch.sliding[0] != touch.sliding[1]:
        raise Unsupported("pymunk has no friction that depends on the direction")
    return touch.sliding[0]


def _factors(count: int, products: Mapping[tuple[int, int], float]) -> tuple[float, ...]:
    """A factor for each surface, so that pairs have their products, as far as that can be, the
    first ones first. The surface in the first pairs that is in most of them has 1."""
    factors = dict[int, float]()
    for pair, value in products.items():
        first, second = pair if pair[0] in factors else pair[::-1]
        if first not in factors:
            first, second = sorted(pair, key=lambda n: -sum(n in other for other in products))
        known = factors.setdefault(first, 1.0)
        factors.setdefault(second, value / known if known else 1.0)
    return tuple(factors.get(number, 1.0) for number in range(count))


def _reach(
    mechanism: Mechanism, links: Links, start: State, found: Sequence[Surface], size: float
) -> float:
    """How far a floor extends to either side [m]: no body gets further within FLOOR_TIME."""
    rates = [mechanism.joints[n].kind == "hinge" for n in range(len(start.qvel))]
    speed = float(np.sum(np.abs(start.qvel) * np.where(rates, size, 1.0)))
    floors = [surface.normal for surface in found if surface.normal]
    gravity = links.plane.flat(mechanism.gravity)
    pull = max((abs((gravity * floor.conjugate()).imag) for floor in floors), default=0.0)
    return FLOOR_TIME * speed + 0.5 * pull * FLOOR_TIME**2 + size
