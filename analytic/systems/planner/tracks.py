"""Where the slider may go: anywhere, or along an arc of the circle and segments of two lines."""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np

from plumbob.analytic.parameters import ParameterError, numbers, positive
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import (
    Arc,
    Capsule,
    Point,
    direction_to,
    longest_stroke,
    validity,
)
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import ClosedForm, closed_form
from plumbob.analytic.systems.planner.manoeuvre import (
    ANYWHERE,
    ARC,
    FIRST,
    NEAR,
    SECOND,
    Manoeuvre,
    Place,
    slow_arc,
    slow_line,
)
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, Limits

# places round the circle for the first turn to begin at
ROUND = tuple(k / 24 for k in range(24))
ON_ARC = (0.0, 0.5, 1.0)  # and on an arc
LEAST_LOAD = 0.1  # of a support's load with the slider at C, to remain on a rail

Pair = tuple[int, int]
"""The supports at whose directions the curve's segments lie, 1, 2 or 3, in the order of the places
along it."""
ArcName = Literal["shorter", "longer"]
Ends = tuple[float, float]
LineSegment = tuple[float, float, float]
"""A segment of a line through C: the line's direction [rad, from the body's x axis], and the ends,
signed along it from C [m]."""


class Rail(NamedTuple):
    """A straight `part` of the track on a line through C: the slider may go in `direction` [rad,
    from the body's x axis] from `low` to `high`, signed along it from C [m]."""

    direction: float
    low: float
    high: float
    part: int = ANYWHERE

    def place(self, along: float) -> Place:
        """The place `along` it [m]."""
        return Place(self.part, cmath.rect(along, self.direction))

    @property
    def backward(self) -> Rail:
        """The same places, the slider going the other way."""
        return Rail(self.direction + math.pi, -self.high, -self.low, self.part)


Legs = tuple[tuple[Rail, float], ...]
"""Rails, each with the distance [m] that the body moves along it."""


@dataclass(frozen=True)
class Circle:
    """The part of the circle that turns use, the slider going round in the direction `sense`.

    A turn is of at most `longest` [rad]. With `extent` [rad] the turns keep to the arc of that
    length from angle `first` [rad], all of them begin at one place, and the slider returns after
    each; without, each begins where the last one ended. `places` are the parts before a turn that
    may be tried: of the arc that it leaves, or of the whole circle.
    """

    sense: float
    longest: float
    first: float
    extent: float | None
    places: Sequence[float]

    def starts(self, swing: float) -> Array:
        """Angles [rad], shape (n,), at which the first turn, through `swing` [rad], may begin."""
        free = FULL_CIRCLE if self.extent is None else self.sense * (self.extent - swing)
        return self.first + free * np.array(self.places)

    def gained(self, heading: float) -> float:
        """A turn's `heading` [rad], positive the way that the slider is to turn the body, against
        its own, and negative the other way."""
        return -self.sense * heading


@dataclass(frozen=True)
class Track:
    """Where turns and lines take the slider, and slow motions between them.

    Lines are on two `segments`, or on any line through C, because eq. 22 of Chernousko 2020 holds
    for all of them; turns are on the `arc` between two angles [rad], or all round the circle. Where
    both segments meet the arc, the slider keeps to this curve and has one degree of freedom (fig.
    1); else it goes from one piece to another straight, or by way of C. Raises ParameterError.
    """

    capsule: Capsule
    limits: Limits
    segments: tuple[Rail, ...] = ()
    arc: Ends | None = None

    def __post_init__(self) -> None:
        positive("friction", self.capsule.friction)
        if validity(self.capsule, ((0.0, 0.0),)):
            need = "such that C is inside their triangle"
            raise ParameterError("supports", self.capsule.supports, need)
        for breach in validity(
            self.capsule, (Arc(self.limits.radius, *(self.arc or (0.0, 7.0))),)
        ):
            need = f"small enough to keep every support pressed to the ground ({breach})"
            raise ParameterError("radius", self.limits.radius, need)
        if self.arc and not NEAR < abs(self.arc[1] - self.arc[0]) <= FULL_CIRCLE:
            need = "two angles [from, to], different and within one turn of each other"
            raise ParameterError("arc", self.arc, need)
        lines = tuple(rail[:3] for rail in self.segments)
        for rail in self.segments:
            if not rail.high - rail.low > NEAR:
                need = "[direction, from, to] each, `from` and `to` apart"
                raise ParameterError("segments", lines, need)
            ends = (rail.place(along).point for along in (rail.low, rail.high))
            for breach in validity(self.capsule, [(end.real, end.imag) for end in ends]):
                need = f"where every support stays pressed ({breach})"
                raise ParameterError("segments", lines, need)

    @property
    def w2(self) -> float:
        """The acceleration that stops the slider in a line [m/s^2]."""
        return self.limits.holding * self.capsule.holding_acceleration

    @cached_property
    def unit_line(self) -> ClosedForm:
        """The line manoeuvre with t1 = 1 s: displacements scale with t1^2, times with t1."""
        return closed_form(self.capsule, self.limits.acceleration, self.w2, 1.0)

    @cached_property
    def joints(self) -> dict[int, tuple[Place, Place]]:
        """Of a segment that meets the arc the place there, on the segment and on the arc."""
        met = dict[int, tuple[Place, Place]]()
        for rail in self.segments:
            for along in (self.limits.radius, -self.limits.radius):
                angle = self._on_arc(
                    rail.direction if along > 0.0 else rail.direction + math.pi
                )
                if rail.low - NEAR <= along <= rail.high + NEAR and angle is not None:
                    met.setdefault(rail.part, (rail.place(along), self.on_circle(angle)))
        return met

    @property
    def joined(self) -> bool:
        """Whether the pieces are one curve."""
        return len(self.joints) == 2

    def _on_arc(self, angle: float) -> float | None:
        """`angle` [rad] as counted along the arc, within whole turns; None off it."""
        if self.arc is None:
            return None
        first, last = self.arc
        sense = math.copysign(1.0, last - first)
        gone = (sense * (angle - first) + NEAR) % FULL_CIRCLE - NEAR
        return first + sense * gone if gone <= abs(last - first) + NEAR else None

    def places(self, point: Point) -> tuple[Place, ...]:
        """Every place at `point` relative to C [m]; raises ParameterError if there is none."""
        there = complex(*point)
        if not self.joined:
            return (Place(ANYWHERE, there),)
        near = list[Place]()
        for rail in self.segments:
            along = there * cmath.rect(1.0, -rail.direction)
            if abs(along.imag) <= NEAR and rail.low - NEAR <= along.real <= rail.high + NEAR:
                near.append(Place(rail.part, there))
        angle = self._on_arc(cmath.phase(there))
        if angle is not None and abs(abs(there) - self.limits.radius) <= NEAR:
            near.append(Place(ARC, there, angle))
        if not near:
            raise ParameterError("slider", point, "on the curve: segment, arc, segment")
        return tuple(near)

    def circle(self, sense: float, *, returning: bool) -> Circle:
        """The part of the circle for turns of that `sense`: all of it round, or the arc from the
        end where all of it lies ahead; if `returning`, from one place."""
        longest = self.limits.stroke / self.limits.radius
        if self.arc is None:
            around = (longest, (0.0,)) if returning else (None, ROUND)
            return Circle(sense, longest, 0.0, *around)
        first, last = self.arc if sense * (self.arc[1] - self.arc[0]) > 0.0 else self.arc[::-1]
        extent = abs(last - first)
        places = (0.0,) if returning else ON_ARC
        return Circle(sense, min(extent, longest), first, extent, places)

    def on_circle(self, angle: float) -> Place:
        """The place on the circle at `angle` [rad]."""
        part = ANYWHERE if self.arc is None else ARC
        return Place(part, cmath.rect(self.limits.radius, angle), angle)

    def legs(self, displacement: complex) -> tuple[Legs, ...]:
        """Ways to carry the body over `displacement` [m], in body axes: along the two segments in
        either order, or straight."""
        if not self.segments:
            return (((self._any_rail(cmath.phase(-displacement)), abs(displacement)),),)
        sides = np.array([rail.direction for rail in self.segments])
        axes = np.stack([np.cos(sides), np.sin(sides)])
        parts = np.linalg.solve(axes, [displacement.real, displacement.imag])
        legs = tuple(
            (rail if part < 0.0 else rail.backward, float(abs(part)))
            for rail, part in zip(self.segments, parts, strict=True)
            if abs(part) > NEAR
        )
        return tuple(dict.fromkeys((legs, legs[::-1])))

    def _any_rail(self, direction: float) -> Rail:
        """A rail in that direction [rad], on which no support load falls below a part of what it is
        with the slider at C."""
        behind, ahead = longest_stroke(self.capsule, direction, LEAST_LOAD)
        length = min(self.limits.stroke, ahead - behind)
        high = min(max(0.5 * length, length + behind), ahead)
        return Rail(direction, high - length, high)

    def route(self, begin: Place, end: Place) -> tuple[Manoeuvre, ...]:
        """The slow motions from one place to another: along one piece, along the curve with stops
        at its corners, or else the quicker of straight and by way of C, where static friction
        allows most."""
        c = Place(ANYWHERE, 0j)
        ways = [((begin, end),), ((begin, c), (c, end))]
        if begin.part == end.part != ANYWHERE:
            ways = ways[:1]
        elif self.joined:
            (off, onto), (last, onto_last) = (
                self.joints.get(place.part, (place, place)) for place in (begin, end)
            )
            ways = [((begin, off), (onto, onto_last), (last, end))]
        return min(
            map(self._slow, ways), key=lambda way: sum(motion.duration for motion in way)
        )

    def _slow(self, ways: Sequence[tuple[Place, Place]]) -> tuple[Manoeuvre, ...]:
        """Slow motions, each within one part of the track."""
        capsule = self.capsule
        radius = self.limits.radius
        holding = self.limits.holding
        return tuple(
            slow_arc(capsule, radius, here.angle, there.angle, holding)
            if here.part == there.part == ARC
            else slow_line(capsule, here.point, there.point, holding)
            for here, there in ways
            if here.away(there)
        )


def checked_curve(
    legs: Any = (1, 2), arc: Any = "shorter", segments: Any = None
) -> tuple[Pair, ArcName | Ends, tuple[LineSegment, ...] | None]:
    """The same as tuples; raises ParameterError where `legs` are no two of the supports, `arc` is
    neither a name nor two angles, or `segments` are no two triples of numbers."""
    legs = tuple(legs) if isinstance(legs, list) else legs
    if legs not in itertools.permutations((1, 2, 3), 2) or any(
        type(i) is not int for i in legs
    ):
        raise ParameterError("legs", legs, "two different ones of the supports 1, 2, 3")
    if arc not in ("shorter", "longer"):
        arc = numbers("arc", arc, (2,), "shorter or longer, or two angles [from, to]")
    if segments is not None:
        segments = numbers("segments", segments, (2, 3), "two of [direction, from, to]")
    return legs, arc, segments


def curve(
    capsule: Capsule,
    limits: Limits,
    legs: Pair = (1, 2),
    arc: ArcName | Ends = "shorter",
    segments: tuple[LineSegment, ...] | None = None,
) -> Track:
    """Two `segments` of lines through C and an `arc` of the circle: from angle to angle [rad], or
    from the first line's direction to the second's the shorter way or the longer. Without
    `segments` those from C to the circle towards the supports `legs` (Chernousko 2020, fig. 1).
    Raises ParameterError."""
    legs, arc, segments = checked_curve(legs, arc, segments)
    if segments is None:
        segments = tuple((direction_to(capsule, i), 0.0, limits.radius) for i in legs)
    first, second = lines = tuple(
        Rail(direction, min(ends), max(ends), part)
        for part, (direction, *ends) in zip((FIRST, SECOND), segments, strict=True)
    )
    turned = second.direction - first.direction
    if abs(math.sin(turned)) <= NEAR:
        raise ParameterError("segments", segments, "on two lines, and not on one")
    if not isinstance(arc, str):
        return Track(capsule, limits, lines, arc)
    swing = math.remainder(turned, FULL_CIRCLE)
    if arc == "longer":
        swing -= math.copysign(FULL_CIRCLE, swing)
    return Track(capsule, limits, lines, (first.direction, first.direction + swing))
