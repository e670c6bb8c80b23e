"""The source's single curve as a track: segment, arc, segment; one degree of freedom."""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Arc, Capsule, Point, direction_to
from plumbob.analytic.systems.planner.lines import Push, Rail, line_time
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre, slow_arc, slow_line
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, Limits, check_limits
from plumbob.analytic.systems.planner.tracks import NEAR, Legs
from plumbob.analytic.systems.planner.turns import Circle
from plumbob.analytic.systems.three_points.equations import Complex


@dataclass(frozen=True)
class Curve:
    """The slider may only go along one curve: from C along C-A1 to the circle, round to the line
    C-A2 the shorter way, and along it back to C (Chernousko 2020, fig. 1). A place is the way along
    it from its beginning [m]; its ends do not join, though both are at C."""

    capsule: Capsule
    limits: Limits

    def __post_init__(self) -> None:
        first, swing = self.first, self.swing
        if abs(math.sin(swing)) <= NEAR:
            raise ParameterError(
                "supports", self.capsule.supports, "such that C-A1 and C-A2 are not one line"
            )
        check_limits(self.capsule, self.limits, Arc(self.limits.radius, first, first + swing))

    @property
    def first(self) -> float:
        """Angle of C-A1 [rad]."""
        return direction_to(self.capsule, 1)

    @property
    def swing(self) -> float:
        """Angle from C-A1 to C-A2 the shorter way [rad], with its sign."""
        return math.remainder(direction_to(self.capsule, 2) - self.first, FULL_CIRCLE)

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
            raise ParameterError("slider", point, "on the curve: C-A1, circle, C-A2")
        return tuple(complex(s) for s in dict.fromkeys(found))

    def circle(self, sense: float, returning: bool) -> Circle:
        """See Track: from the end of the arc that has all of it ahead."""
        ahead = sense * self.swing > 0.0
        start, extent = self.first + (0.0 if ahead else self.swing), abs(self.swing)
        longest = min(extent, self.limits.stroke / self.limits.radius)
        return Circle(sense, longest, start, extent, np.array([start]))

    def on_circle(self, angle: float) -> complex:
        """See Track."""
        return complex(self.limits.radius * (1.0 + abs(angle - self.first)))

    def legs(self, displacement: complex) -> tuple[Legs, ...]:
        """See Track: along C-A1 and C-A2, in either order."""
        shares = self._shares(np.array([displacement]))[:, 0]
        legs = tuple(
            (self._rail(number, away=float(share) < 0.0), abs(float(share)))
            for number, share in enumerate(shares)
            if abs(share) > NEAR
        )
        return tuple(dict.fromkeys((legs, legs[::-1])))

    def _shares(self, displacements: Complex) -> Array:
        """Parts along C-A1 and C-A2 [m], shape (2, n), of `displacements`, shape (n,)."""
        sides = (self.first, self.first + self.swing)
        axes = np.array([[math.cos(side), math.sin(side)] for side in sides]).T
        return np.asarray(np.linalg.solve(axes, np.stack([displacements.real, displacements.imag])))

    def line_time(self, push: Push, displacements: Complex) -> Array:
        """See Track."""
        longest, shares = min(self.limits.stroke, self.limits.radius), self._shares(displacements)
        one, two = (
            line_time(self.capsule, self.limits, push, longest, np.abs(share)) for share in shares
        )
        return one + two

    def _rail(self, number: int, away: bool) -> Rail:
        """Segment C-A1 (0) or C-A2 (1), with the slider going away from C or towards it."""
        side = self.first + number * self.swing
        _, one, _, end = self._corners

        def place(along: float) -> complex:
            return complex(end - abs(along) if number else abs(along))

        if away:
            return Rail(side, 0.0, one, place)
        return Rail(side + math.pi, -one, 0.0, place)

    def route(self, begin: complex, end: complex) -> tuple[Manoeuvre, ...]:
        """See Track: along the curve, stopping at its corners."""
        return tuple(self._parts(begin.real, end.real))

    def _parts(self, begin: float, end: float) -> Iterator[Manoeuvre]:
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
