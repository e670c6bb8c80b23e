"""Tracks of the slider: anywhere, or along an arc of the circle and segments of two lines."""

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
    PlanePoint,
    direction_to,
    longest_stroke,
    validity,
)
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import ClosedForm, closed_form
from plumbob.analytic.systems.planner.manoeuvre import (
    ANYWHERE,
    ARC,
    FIRST_SEGMENT,
    SAME_PLACE_DISTANCE,
    SECOND_SEGMENT,
    Manoeuvre,
    TrackPlace,
    slow_arc,
    slow_line,
)
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, PlanLimits

# places at which the first turn may begin, as fractions of the circle
CIRCLE_PLACES = tuple(k / 24 for k in range(24))
# places at which it may begin on an arc, as fractions of the free length
ARC_PLACES = (0.0, 0.5, 1.0)
# Smallest ratio of the load of a support on a rail to its load with the slider at C
LEAST_LOAD = 0.1

SupportPair = tuple[int, int]
"""The two supports (1, 2 or 3) towards which the curve's segments lie, in the order along the
curve."""
ArcName = Literal["shorter", "longer"]
SegmentEnds = tuple[float, float]
LineSegment = tuple[float, float, float]
"""A segment of a line through C: the line's direction [rad, from the body's x axis], and its two
ends [m], signed along the direction from C."""


class Rail(NamedTuple):
    """A straight `part` of the track on a line through C. The slider may move in `direction` [rad,
    from the body's x axis] from `low` to `high` [m], signed along the direction from C."""

    direction: float
    low: float
    high: float
    part: int = ANYWHERE

    def place(self, along: float) -> TrackPlace:
        """Returns the place on the rail at `along` [m], signed along the direction from C."""
        return TrackPlace(self.part, cmath.rect(along, self.direction))

    def reaches(self, along: float) -> bool:
        """Returns True if the place at `along` [m] is on the rail, within SAME_PLACE_DISTANCE."""
        return self.low - SAME_PLACE_DISTANCE <= along <= self.high + SAME_PLACE_DISTANCE

    @property
    def backward(self) -> Rail:
        """This rail with the opposite direction."""
        return Rail(self.direction + math.pi, -self.high, -self.low, self.part)


Legs = tuple[tuple[Rail, float], ...]
"""Rails in order, each with the distance [m] that the body moves along it."""


@dataclass(frozen=True)
class Circle:
    """The part of the circle that turns use. The slider moves round it in the direction `sense`, +1
    or -1.

    One turn is at most `longest` [rad]. If `extent` [rad] is given, the turns stay on the arc of
    this length from angle `first` [rad]: all begin at one place, and the slider returns after each.
    If `extent` is None, each turn begins where the last one ended. `places` are trial places of the
    first turn: the free part of the arc before it, as a fraction, or the fraction of the whole
    circle.
    """

    sense: float
    longest: float
    first: float
    extent: float | None
    places: Sequence[float]

    def starts(self, swing: float) -> Array:
        """Returns the angles [rad], shape (n,), at which the first turn, through `swing` [rad], may
        begin."""
        free = FULL_CIRCLE if self.extent is None else self.sense * (self.extent - swing)
        return self.first + free * np.array(self.places)

    def heading_gain(self, heading: float) -> float:
        """Returns the `heading` [rad] that a turn adds, with the sign + if the body turns against
        the slider, as it should."""
        return -self.sense * heading


@dataclass(frozen=True)
class Track:
    """The places to which turns, lines, and slow motions between them may take the slider.

    Lines are on two `segments`, or on any line through C, because eq. 22 of Chernousko 2020 holds
    for all such lines. Turns are on the `arc` between two angles [rad], or on the whole circle. If
    both segments meet the arc, the slider stays on this curve and has one degree of freedom (fig.
    1). Otherwise it moves from one piece to another straight, or through C. Raises ParameterError.
    """

    capsule: Capsule
    limits: PlanLimits
    segments: tuple[Rail, ...] = ()
    arc: SegmentEnds | None = None

    def __post_init__(self) -> None:
        positive("friction", self.capsule.friction)
        if validity(self.capsule, ((0.0, 0.0),)):
            need = "such that C is inside their triangle"
            raise ParameterError("supports", self.capsule.supports, need)
        circle = Arc(self.limits.radius, *(self.arc or (0.0, 7.0)))
        for breach in validity(self.capsule, (circle,)):
            need = f"small enough to keep every support pressed to the ground ({breach})"
            raise ParameterError("radius", self.limits.radius, need)
        if self.arc and not SAME_PLACE_DISTANCE < abs(self.arc[1] - self.arc[0]) <= FULL_CIRCLE:
            need = "two angles [from, to], different and within one turn of each other"
            raise ParameterError("arc", self.arc, need)
        lines = tuple(rail[:3] for rail in self.segments)
        for rail in self.segments:
            if not rail.high - rail.low > SAME_PLACE_DISTANCE:
                need = "[direction, from, to] each, `from` and `to` apart"
                raise ParameterError("segments", lines, need)
            ends = (rail.place(along).point for along in (rail.low, rail.high))
            for breach in validity(self.capsule, [(end.real, end.imag) for end in ends]):
                need = f"where every support stays pressed ({breach})"
                raise ParameterError("segments", lines, need)

    @property
    def w2(self) -> float:
        """Largest deceleration of the slider in a line [m/s^2]."""
        return self.limits.holding * self.capsule.holding_acceleration

    @cached_property
    def unit_line(self) -> ClosedForm:
        """The line manoeuvre with t1 = 1 s. Displacements are in proportion to t1^2,
        times to t1."""
        return closed_form(self.capsule, self.limits.acceleration, self.w2, 1.0)

    @cached_property
    def joints(self) -> dict[int, tuple[TrackPlace, TrackPlace]]:
        """The places at which a segment meets the arc, by the segment's part: the place as one on
        the segment, and as one on the arc."""
        joints = dict[int, tuple[TrackPlace, TrackPlace]]()
        for rail in self.segments:
            for along in (self.limits.radius, -self.limits.radius):
                direction = rail.direction if along > 0.0 else rail.direction + math.pi
                angle = self._arc_angle(direction)
                if rail.reaches(along) and angle is not None:
                    joints.setdefault(rail.part, (rail.place(along), self.on_circle(angle)))
        return joints

    @property
    def is_curve(self) -> bool:
        """True if the segments and the arc are one curve."""
        return len(self.joints) == 2

    def _arc_angle(self, angle: float) -> float | None:
        """Returns `angle` [rad] shifted by whole turns to lie on the arc, or None if it
        does not."""
        if self.arc is None:
            return None
        first, last = self.arc
        sense = math.copysign(1.0, last - first)
        # An angle just before the first one counts as the first, not as a full circle after it.
        shifted = (sense * (angle - first) + SAME_PLACE_DISTANCE) % FULL_CIRCLE
        from_first = shifted - SAME_PLACE_DISTANCE
        if from_first > abs(last - first) + SAME_PLACE_DISTANCE:
            return None
        return first + sense * from_first

    def places(self, point: PlanePoint) -> tuple[TrackPlace, ...]:
        """Returns all places of the track at `point` relative to C [m]. Raises ParameterError if
        there is none."""
        position = complex(*point)
        if not self.is_curve:
            return (TrackPlace(ANYWHERE, position),)
        places = list[TrackPlace]()
        for rail in self.segments:
            # The parts of `on_axes` are along the rail and across it.
            on_axes = position * cmath.rect(1.0, -rail.direction)
            is_on_line = abs(on_axes.imag) <= SAME_PLACE_DISTANCE
            if is_on_line and rail.reaches(on_axes.real):
                places.append(TrackPlace(rail.part, position))
        angle = self._arc_angle(cmath.phase(position))
        if angle is not None and abs(abs(position) - self.limits.radius) <= SAME_PLACE_DISTANCE:
            places.append(TrackPlace(ARC, position, angle))
        if not places:
            raise ParameterError("slider", point, "on the curve: segment, arc, segment")
        return tuple(places)

    def circle(self, sense: float, *, returning: bool) -> Circle:
        """Returns the part of the circle for turns in the direction `sense`: the whole circle, or
        the arc from its end. If `returning`, all turns begin at one place."""
        longest = self.limits.stroke / self.limits.radius
        if self.arc is None:
            extent = longest if returning else None
            places = (0.0,) if returning else CIRCLE_PLACES
            return Circle(sense, longest, 0.0, extent, places)
        first, last = self.arc if sense * (self.arc[1] - self.arc[0]) > 0.0 else self.arc[::-1]
        extent = abs(last - first)
        places = (0.0,) if returning else ARC_PLACES
        return Circle(sense, min(extent, longest), first, extent, places)

    def on_circle(self, angle: float) -> TrackPlace:
        """Returns the place on the circle at `angle` [rad]."""
        part = ANYWHERE if self.arc is None else ARC
        return TrackPlace(part, cmath.rect(self.limits.radius, angle), angle)

    def legs(self, displacement: complex) -> tuple[Legs, ...]:
        """Returns ways to carry the body over `displacement` [m], in body axes: straight, or along
        the two segments in either order. The slider moves along a leg against the body."""
        if not self.segments:
            rail = self._free_rail(cmath.phase(-displacement))
            return (((rail, abs(displacement)),),)
        directions = np.array([rail.direction for rail in self.segments])
        axes = np.stack([np.cos(directions), np.sin(directions)])
        parts = np.linalg.solve(axes, [displacement.real, displacement.imag])
        legs: Legs = ()
        for rail, part in zip(self.segments, parts, strict=True):
            if abs(part) > SAME_PLACE_DISTANCE:
                # The body moves against the slider.
                leg = rail if part < 0.0 else rail.backward
                legs = (*legs, (leg, float(abs(part))))
        return tuple(dict.fromkeys((legs, legs[::-1])))

    def _free_rail(self, direction: float) -> Rail:
        """Returns a rail in `direction` [rad] on which every support keeps at least the part
        LEAST_LOAD of its load with the slider at C."""
        behind, ahead = longest_stroke(self.capsule, direction, LEAST_LOAD)
        length = min(self.limits.stroke, ahead - behind)
        high = min(max(0.5 * length, length + behind), ahead)
        return Rail(direction, high - length, high)

    def route(self, begin: TrackPlace, end: TrackPlace) -> tuple[Manoeuvre, ...]:
        """Returns the slow motions from one place to another. Within one piece they follow that
        piece; on a curve they follow the curve and stop at its corners. Otherwise they are the
        faster of two ways: straight, or through C, where static friction allows the largest
        acceleration."""
        centre = TrackPlace(ANYWHERE, 0j)  # C
        ways = [((begin, end),), ((begin, centre), (centre, end))]
        if begin.part == end.part != ANYWHERE:
            ways = ways[:1]
        elif self.is_curve:
            # A place on the arc is its own corner.
            leave_segment, enter_arc = self.joints.get(begin.part, (begin, begin))
            enter_segment, leave_arc = self.joints.get(end.part, (end, end))
            ways = [((begin, leave_segment), (enter_arc, leave_arc), (enter_segment, end))]
        motions_of_ways = [self._slow_motions(way) for way in ways]
        return min(
            motions_of_ways, key=lambda motions: sum(motion.duration for motion in motions)
        )

    def _slow_motions(
        self, pairs: Sequence[tuple[TrackPlace, TrackPlace]]
    ) -> tuple[Manoeuvre, ...]:
        """Returns slow motions between pairs of places; both places of a pair are on one part of
        the track."""
        capsule = self.capsule
        radius = self.limits.radius
        holding = self.limits.holding
        motions = list[Manoeuvre]()
        for begin, end in pairs:
            if not begin.differs_from(end):
                continue
            if begin.part == end.part == ARC:
                motions.append(slow_arc(capsule, radius, begin.angle, end.angle, holding))
            else:
                motions.append(slow_line(capsule, begin.point, end.point, holding))
        return tuple(motions)


def checked_curve(
    legs: Any = (1, 2), arc: Any = "shorter", segments: Any = None
) -> tuple[SupportPair, ArcName | SegmentEnds, tuple[LineSegment, ...] | None]:
    """Returns the arguments as tuples. Raises ParameterError if `legs` are not the numbers of two
    different supports, `arc` is neither a name nor two angles, or `segments` are not two triples of
    numbers."""
    legs = tuple(legs) if isinstance(legs, list) else legs
    is_pair = legs in itertools.permutations((1, 2, 3), 2)
    if not is_pair or any(type(i) is not int for i in legs):
        raise ParameterError("legs", legs, "two different ones of the supports 1, 2, 3")
    if arc not in ("shorter", "longer"):
        arc = numbers("arc", arc, (2,), "shorter or longer, or two angles [from, to]")
    if segments is not None:
        segments = numbers("segments", segments, (2, 3), "two of [direction, from, to]")
    return legs, arc, segments


def curved_track(
    capsule: Capsule,
    limits: PlanLimits,
    legs: SupportPair = (1, 2),
    arc: ArcName | SegmentEnds = "shorter",
    segments: tuple[LineSegment, ...] | None = None,
) -> Track:
    """Returns the track of two `segments` of lines through C and an `arc` of the circle. The arc is
    two angles [rad], or goes from the first line's direction to the second's, the shorter way or
    the longer. If `segments` is None, they lead from C to the circle towards the supports `legs`
    (Chernousko 2020, fig. 1). Raises ParameterError."""
    legs, arc, segments = checked_curve(legs, arc, segments)
    if segments is None:
        segments = tuple((direction_to(capsule, i), 0.0, limits.radius) for i in legs)
    rails = []
    for part, segment in zip((FIRST_SEGMENT, SECOND_SEGMENT), segments, strict=True):
        direction, *ends = segment
        rails.append(Rail(direction, min(ends), max(ends), part))
    first, second = rails
    angle = second.direction - first.direction
    if abs(math.sin(angle)) <= SAME_PLACE_DISTANCE:
        raise ParameterError("segments", segments, "on two lines, and not on one")
    if not isinstance(arc, str):
        return Track(capsule, limits, (first, second), arc)
    swing = math.remainder(angle, FULL_CIRCLE)
    if arc == "longer":
        swing -= math.copysign(FULL_CIRCLE, swing)
    ends_of_arc = first.direction, first.direction + swing
    return Track(capsule, limits, (first, second), ends_of_arc)
