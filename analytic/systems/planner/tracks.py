"""Tracks, where the slider may go: the protocol, the free plane and the single curve."""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, Protocol

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
from plumbob.analytic.systems.planner.lines import Push, Rail, line_time
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre, slow_arc, slow_line
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, Limits, check_limits
from plumbob.analytic.systems.planner.turns import Circle
from plumbob.analytic.systems.three_points.equations import Complex

NEAR = 1e-12  # [m] two places of the slider this near are one
STARTS = 24  # places round the circle for the first turn to begin at
LEAST_LOAD = 0.1  # of a support's load with the slider at C, to remain on a rail

Legs = tuple[tuple[Rail, float], ...]
"""Rails, each with the distance [m] that the body moves along it."""


Pair = tuple[int, int]
"""The supports at whose directions the curve's segments lie, 1, 2 or 3, in the order of the places
along it."""
ArcName = Literal["shorter", "longer"]


def check_curve(supports: Pair, arc: ArcName) -> None:
    """Raises ParameterError where `supports` are no two of 1, 2, 3, or `arc` is no name."""
    whole = isinstance(supports, tuple) and all(type(i) is int for i in supports)
    if not (whole and len(set(supports)) == len(supports) == 2 and set(supports) <= {1, 2, 3}):
        raise ParameterError("legs", supports, "two different ones of the supports 1, 2, 3")
    if arc not in ("shorter", "longer"):
        raise ParameterError("arc", arc, "shorter or longer")


class Track(Protocol):
    """Where the slider may go; a place on a track is a complex number whose meaning it defines."""

    def places(self, point: Point) -> tuple[complex, ...]:
        """Every place at `point` relative to C [m]; raises ParameterError if there is none."""
        ...

    def circle(self, sense: float, returning: bool) -> Circle:
        """The part of the circle for turns of that `sense`; the slider returns after each turn if
        `returning` or if the track requires it."""
        ...

    def on_circle(self, angle: float) -> complex:
        """The place on the circle at `angle` [rad]."""
        ...

    def legs(self, displacement: complex) -> tuple[Legs, ...]:
        """Ways to carry the body over `displacement` [m], in body axes."""
        ...

    def line_time(self, push: Push, displacements: Complex) -> Array:
        """Estimated time [s], shape (n,), of lines for `displacements` [m], shape (n,), in body
        axes."""
        ...

    def route(self, begin: complex, end: complex) -> tuple[Manoeuvre, ...]:
        """The quickest slow motions from one place to another."""
        ...


@dataclass(frozen=True)
class FreePlane:
    """Track on which the slider may go anywhere; a place is x + iy relative to C [m]. One rail
    along a line through C is enough, because eq. 22 of Chernousko 2020 holds for all of them."""

    capsule: Capsule
    limits: Limits

    def __post_init__(self) -> None:
        check_limits(self.capsule, self.limits, Arc(self.limits.radius, 0.0, FULL_CIRCLE))

    def places(self, point: Point) -> tuple[complex, ...]:
        """See Track."""
        return (complex(*point),)

    def circle(self, sense: float, returning: bool) -> Circle:
        """See Track."""
        longest = self.limits.stroke / self.limits.radius
        starts = FULL_CIRCLE * np.arange(STARTS) / STARTS
        return Circle(sense, longest, 0.0, longest if returning else None, starts)

    def on_circle(self, angle: float) -> complex:
        """See Track."""
        return cmath.rect(self.limits.radius, angle)

    def legs(self, displacement: complex) -> tuple[Legs, ...]:
        """See Track."""
        direction = cmath.phase(-displacement)
        ahead, behind = self._reach(direction), self._reach(direction + math.pi)
        length = min(self.limits.stroke, ahead + behind)
        high = min(max(0.5 * length, length - behind), ahead)

        def place(along: float) -> complex:
            return cmath.rect(along, direction)

        return (((Rail(direction, high - length, high, place), abs(displacement)),),)

    def _spare(self) -> Array:
        """Fraction of the weight by which each support load may fall, shape (3,)."""
        return np.asarray((1.0 - LEAST_LOAD) * load_fractions(self.capsule, np.zeros((1, 2)))[0])

    def _reach(self, direction: float) -> float:
        """How far the slider may go from C [m] before a support load is too small."""
        slopes = load_slopes(self.capsule, direction) / self.capsule.weight
        falling = slopes < 0.0
        return float((self._spare()[falling] / -slopes[falling]).min())

    def line_time(self, push: Push, displacements: Complex) -> Array:
        """See Track; the rail has its length in the worst direction."""
        x, y = (load_slopes(self.capsule, a) / self.capsule.weight for a in (0.0, 0.5 * math.pi))
        reach = float((self._spare() / np.hypot(x, y)).min())
        longest = min(self.limits.stroke, 2.0 * reach)
        return line_time(self.capsule, self.limits, push, longest, np.abs(displacements))

    def route(self, begin: complex, end: complex) -> tuple[Manoeuvre, ...]:
        """See Track: straight, or by way of C, where static friction allows most."""
        holding = self.limits.holding
        if abs(end - begin) <= NEAR:
            return ()
        straight = (slow_line(self.capsule, begin, end, holding),)
        if abs(begin) <= NEAR or abs(end) <= NEAR:
            return straight
        inward = slow_line(self.capsule, begin, 0j, holding)
        outward = slow_line(self.capsule, 0j, end, holding)
        return min(straight, (inward, outward), key=lambda way: sum(leg.duration for leg in way))


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
    def _corners(self) -> tuple[float, float, float, float]:
        a = self.limits.radius
        return 0.0, a, a + a * abs(self.swing), 2.0 * a + a * abs(self.swing)

    def point(self, place: float) -> complex:
        """The point relative to C [m] at `place`."""
        _, one, two, end = self._corners
        if place <= one:
            return cmath.rect(place, self.first)
        if place >= two:
            return cmath.rect(end - place, self.first + self.swing)
        return cmath.rect(self.limits.radius, self._angle(place))

    def _angle(self, place: float) -> float:
        turned = (place - self.limits.radius) / self.limits.radius
        return self.first + math.copysign(turned, self.swing)

    def places(self, point: Point) -> tuple[complex, ...]:
        """See Track."""
        there, (_, one, _, end) = complex(*point), self._corners
        candidates = [abs(there), end - abs(there)]
        turned = math.copysign(1.0, self.swing) * (cmath.phase(there) - self.first)
        candidates.append(one + self.limits.radius * (turned % FULL_CIRCLE))
        found = [s for s in candidates if 0.0 <= s <= end and abs(self.point(s) - there) <= NEAR]
        if not found:
            i, j = self.supports
            raise ParameterError("slider", point, f"on the curve: C-A{i}, circle, C-A{j}")
        return tuple(complex(s) for s in dict.fromkeys(found))

    def circle(self, sense: float, returning: bool) -> Circle:
        """See Track; a turn starts at the end of the arc from which all of it lies ahead."""
        ahead = sense * self.swing > 0.0
        start, extent = self.first + (0.0 if ahead else self.swing), abs(self.swing)
        longest = min(extent, self.limits.stroke / self.limits.radius)
        return Circle(sense, longest, start, extent, np.array([start]))

    def on_circle(self, angle: float) -> complex:
        """See Track."""
        return complex(self.limits.radius * (1.0 + abs(angle - self.first)))

    def legs(self, displacement: complex) -> tuple[Legs, ...]:
        """See Track: along C-Ai and C-Aj, in either order."""
        parts = self._parts_of(np.array([displacement]))[:, 0]
        legs = tuple(
            (self._rail(number, away=float(part) < 0.0), abs(float(part)))
            for number, part in enumerate(parts)
            if abs(part) > NEAR
        )
        return tuple(dict.fromkeys((legs, legs[::-1])))

    def _parts_of(self, displacements: Complex) -> Array:
        """Components along C-Ai and C-Aj [m], shape (2, n), of `displacements`, shape (n,)."""
        sides = (self.first, self.first + self.swing)
        axes = np.array([[math.cos(side), math.sin(side)] for side in sides]).T
        return np.asarray(np.linalg.solve(axes, np.stack([displacements.real, displacements.imag])))

    def line_time(self, push: Push, displacements: Complex) -> Array:
        """See Track."""
        longest = min(self.limits.stroke, self.limits.radius)
        one, two = (
            line_time(self.capsule, self.limits, push, longest, np.abs(part))
            for part in self._parts_of(displacements)
        )
        return one + two

    def _rail(self, number: int, away: bool) -> Rail:
        """Segment C-Ai (0) or C-Aj (1), with the slider going away from C or towards it."""
        side = self.first + number * self.swing
        _, one, _, end = self._corners

        def place(along: float) -> complex:
            return complex(end - abs(along) if number else abs(along))

        if away:
            return Rail(side, 0.0, one, place)
        return Rail(side + math.pi, -one, 0.0, place)

    def route(self, begin: complex, end: complex) -> tuple[Manoeuvre, ...]:
        """See Track: along the curve, stopping at its corners."""
        return tuple(self._legs_between(begin.real, end.real))

    def _legs_between(self, begin: float, end: float) -> Iterator[Manoeuvre]:
        low, high = min(begin, end), max(begin, end)
        inner = [s for s in self._corners if low + NEAR < s < high - NEAR]
        stops = [low, *inner, high]
        if begin > end:
            stops.reverse()
        holding = self.limits.holding
        for one, two in itertools.pairwise(stops):
            if abs(two - one) <= NEAR:
                continue
            middle = 0.5 * (one + two)
            if self._corners[1] < middle < self._corners[2]:
                angles = self._angle(one), self._angle(two)
                yield slow_arc(self.capsule, self.limits.radius, *angles, holding)
            else:
                yield slow_line(self.capsule, self.point(one), self.point(two), holding)
