"""Tracks, where the slider may go: the free plane, and the source's single curve."""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import (
    Arc,
    Capsule,
    Point,
    direction_to,
    load_fractions,
    load_slopes,
)
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre, slow_arc, slow_line
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, Limits, check_limits

NEAR = 1e-12  # [m] two places of the slider this near are one
ROUND = tuple(k / 24 for k in range(24))  # places round the circle for the first turn to begin at
ON_ARC = (0.0, 0.5, 1.0)  # and on an arc
LEAST_LOAD = 0.1  # of a support's load with the slider at C, to remain on a rail

Pair = tuple[int, int]
"""The supports at whose directions the curve's segments lie, 1, 2 or 3, in the order of the places
along it."""
ArcName = Literal["shorter", "longer"]


@dataclass(frozen=True)
class Rail:
    """A straight part of the track on a line through C: the slider may go in `direction` [rad, from
    the body's x axis] from `low` to `high`, signed along it from C [m]; `place` names the track's
    place there."""

    direction: float
    low: float
    high: float
    place: Callable[[float], complex]


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
    places: Sequence[float] = (0.0,)

    def starts(self, swing: float) -> Array:
        """Angles [rad], shape (n,), at which the first turn, through `swing` [rad], may begin."""
        free = FULL_CIRCLE if self.extent is None else self.sense * (self.extent - swing)
        return self.first + free * np.array(self.places)

    def gained(self, heading: float) -> float:
        """A turn's `heading` [rad], positive the way that the slider is to turn the body, against
        its own, and negative the other way."""
        return -self.sense * heading


@dataclass(frozen=True)
class FreePlane:
    """Track on which the slider may go anywhere; a place is x + iy relative to C [m]. One rail
    along a line through C is enough, because eq. 22 of Chernousko 2020 holds for all of them."""

    capsule: Capsule
    limits: Limits

    def __post_init__(self) -> None:
        check_limits(self.capsule, self.limits, Arc(self.limits.radius, 0.0, FULL_CIRCLE))

    def places(self, point: Point) -> tuple[complex, ...]:
        """Every place at `point` relative to C [m]."""
        return (complex(*point),)

    def circle(self, sense: float, *, returning: bool) -> Circle:
        """The part of the circle for turns of that `sense`; the slider goes on all round, unless it
        is `returning` after each turn."""
        longest = self.limits.stroke / self.limits.radius
        if returning:
            return Circle(sense, longest, 0.0, longest)
        return Circle(sense, longest, 0.0, None, ROUND)

    def on_circle(self, angle: float) -> complex:
        """The place on the circle at `angle` [rad]."""
        return cmath.rect(self.limits.radius, angle)

    def legs(self, displacement: complex) -> tuple[Legs, ...]:
        """Ways to carry the body over `displacement` [m], in body axes: here one, straight. On the
        rail no support load falls below a part of what it is with the slider at C."""
        direction = cmath.phase(-displacement)
        load = load_fractions(self.capsule, np.zeros((1, 2)))[0] * self.capsule.weight
        falls = -load_slopes(self.capsule, direction) / ((1.0 - LEAST_LOAD) * load)
        ahead, behind = 1.0 / float(falls.max()), -1.0 / float(falls.min())
        length = min(self.limits.stroke, ahead + behind)
        high = min(max(0.5 * length, length - behind), ahead)
        rail = Rail(direction, high - length, high, lambda along: cmath.rect(along, direction))
        return (((rail, abs(displacement)),),)

    def route(self, begin: complex, end: complex) -> tuple[Manoeuvre, ...]:
        """The quickest slow motions from one place to another: straight, or by way of C, where
        static friction allows most."""
        straight, by_c = (
            tuple(
                slow_line(self.capsule, here, there, self.limits.holding)
                for here, there in itertools.pairwise(stops)
                if abs(there - here) > NEAR
            )
            for stops in ((begin, end), (begin, 0j, end))
        )
        return min(straight, by_c, key=lambda way: sum(motion.duration for motion in way))


@dataclass(frozen=True)
class Curve:
    """Track of one degree of freedom: from C along C-Ai to the circle, round to the line C-Aj the
    shorter way or the longer, and along it back to C (Chernousko 2020, fig. 1), where i and j are
    the `supports`. A place is the arc length from its beginning [m]; its ends do not join, though
    both are at C. Raises ParameterError."""

    capsule: Capsule
    limits: Limits
    supports: Pair = (1, 2)
    arc: ArcName = "shorter"

    def __post_init__(self) -> None:
        check_curve(self.supports, self.arc)
        first, swing = self.first, self.swing
        if abs(math.sin(swing)) <= NEAR:
            i, j = self.supports
            raise ParameterError(
                "supports", self.capsule.supports, f"such that C-A{i} and C-A{j} are not one line"
            )
        check_limits(self.capsule, self.limits, Arc(self.limits.radius, first, first + swing))

    @property
    def first(self) -> float:
        """Angle of C-Ai [rad]."""
        return direction_to(self.capsule, self.supports[0])

    @property
    def swing(self) -> float:
        """Angle from C-Ai to C-Aj along the arc [rad], with its sign."""
        swing = direction_to(self.capsule, self.supports[1]) - self.first
        shorter = math.remainder(swing, FULL_CIRCLE)
        if self.arc == "shorter":
            return shorter
        return shorter - math.copysign(FULL_CIRCLE, shorter)

    @property
    def _length(self) -> float:
        """Arc length in all [m]: the radius is that of either line."""
        return self.limits.radius * (2.0 + abs(self.swing))

    def _angle(self, place: float) -> float:
        """Angle of the point at `place` [rad]."""
        turned = min(max(place / self.limits.radius - 1.0, 0.0), abs(self.swing))
        return self.first + math.copysign(turned, self.swing)

    def _point(self, place: float) -> complex:
        """The point relative to C [m] at `place`."""
        out = min(place, self.limits.radius, self._length - place)
        return cmath.rect(out, self._angle(place))

    def places(self, point: Point) -> tuple[complex, ...]:
        """Every place at `point` relative to C [m]; raises ParameterError if there is none."""
        there = complex(*point)
        turned = math.copysign(1.0, self.swing) * (cmath.phase(there) - self.first)
        on_arc = self.limits.radius * (1.0 + turned % FULL_CIRCLE)
        places = dict.fromkeys((abs(there), self._length - abs(there), on_arc))
        near = [complex(s) for s in places if abs(self._point(s) - there) <= NEAR]
        if not near:
            i, j = self.supports
            raise ParameterError("slider", point, f"on the curve: C-A{i}, circle, C-A{j}")
        return tuple(near)

    def circle(self, sense: float, *, returning: bool) -> Circle:
        """The arc, from the end of which all of it lies ahead for turns of that `sense`; the slider
        returns after each, and if `returning` is said all of them begin there."""
        first, extent = self.first, abs(self.swing)
        if sense * self.swing < 0.0:
            first += self.swing
        longest = min(extent, self.limits.stroke / self.limits.radius)
        return Circle(sense, longest, first, extent, (0.0,) if returning else ON_ARC)

    def on_circle(self, angle: float) -> complex:
        """The place on the circle at `angle` [rad]."""
        return complex(self.limits.radius * (1.0 + abs(angle - self.first)))

    def legs(self, displacement: complex) -> tuple[Legs, ...]:
        """Ways to carry the body over `displacement` [m], in body axes: along C-Ai and C-Aj, in
        either order."""
        sides = np.array([self.first, self.first + self.swing])
        axes = np.stack([np.cos(sides), np.sin(sides)])
        parts = np.linalg.solve(axes, [displacement.real, displacement.imag])
        legs = tuple(
            (self._rail(number, away=part < 0.0), float(abs(part)))
            for number, part in enumerate(parts)
            if abs(part) > NEAR
        )
        return tuple(dict.fromkeys((legs, legs[::-1])))

    def _rail(self, number: int, *, away: bool) -> Rail:
        """Segment C-Ai (0) or C-Aj (1), with the slider going away from C or towards it."""
        side, radius, end = self.first + number * self.swing, self.limits.radius, self._length
        ends = (side, 0.0, radius) if away else (side + math.pi, -radius, 0.0)
        return Rail(*ends, lambda along: complex(end - abs(along) if number else abs(along)))

    def route(self, begin: complex, end: complex) -> tuple[Manoeuvre, ...]:
        """The slow motions from one place to another along the curve, stopping at its corners."""
        low, high = sorted((begin.real, end.real))
        corners = self.limits.radius, self._length - self.limits.radius
        inner = (s for s in corners if low + NEAR < s < high - NEAR)
        stops = sorted((low, *inner, high), reverse=begin.real > end.real)
        return tuple(
            self._slow(here, there)
            for here, there in itertools.pairwise(stops)
            if abs(there - here) > NEAR
        )

    def _slow(self, here: float, there: float) -> Manoeuvre:
        """The slow motion between two places of one part of the curve."""
        capsule, limits = self.capsule, self.limits
        angles = self._angle(here), self._angle(there)
        if abs(angles[0] - angles[1]) > NEAR:
            return slow_arc(capsule, limits.radius, *angles, limits.holding)
        return slow_line(capsule, self._point(here), self._point(there), limits.holding)


Track = FreePlane | Curve


def check_curve(supports: Pair, arc: ArcName) -> None:
    """Raises ParameterError where `supports` are no two of 1, 2, 3, or `arc` is no name."""
    pairs = itertools.permutations((1, 2, 3), 2)
    if supports not in pairs or any(type(i) is not int for i in supports):
        raise ParameterError("legs", supports, "two different ones of the supports 1, 2, 3")
    if arc not in ("shorter", "longer"):
        raise ParameterError("arc", arc, "shorter or longer")
