"""The free plane as a track: the slider may go anywhere, and one rail along any line is enough."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Arc, Capsule, Point, load_shares, load_slopes
from plumbob.analytic.systems.planner.lines import Push, Rail, line_time
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre, slow_line
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, Limits, check_limits
from plumbob.analytic.systems.planner.tracks import NEAR, Legs
from plumbob.analytic.systems.planner.turns import Circle
from plumbob.analytic.systems.three_points.equations import Complex

STARTS = 24  # places round the circle for the first turn to begin at
LEAST_LOAD = 0.1  # of what a support carries with the slider at C, left to it on a rail


@dataclass(frozen=True)
class FreePlane:
    """The slider may go anywhere; a place is x + iy relative to C [m]. One rail along any line
    through C is enough, for eq. 22 of Chernousko 2020 holds along every one."""

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
        """Share of the weight that each support may lose, shape (3,)."""
        return np.asarray((1.0 - LEAST_LOAD) * load_shares(self.capsule, np.zeros((1, 2)))[0])

    def _reach(self, direction: float) -> float:
        """How far the slider may go from C [m] before a support has too little left to carry."""
        slopes = load_slopes(self.capsule, direction) / self.capsule.weight
        falling = slopes < 0.0
        return float((self._spare()[falling] / -slopes[falling]).min())

    def line_time(self, push: Push, displacements: Complex) -> Array:
        """See Track: with the rail as long as it is in the worst direction."""
        x, y = (load_slopes(self.capsule, a) / self.capsule.weight for a in (0.0, 0.5 * math.pi))
        reach = float((self._spare() / np.hypot(x, y)).min())
        longest = min(self.limits.stroke, 2.0 * reach)
        return line_time(self.capsule, self.limits, push, longest, np.abs(displacements))

    def route(self, begin: complex, end: complex) -> tuple[Manoeuvre, ...]:
        """See Track: straight, or by way of C, along lines that friction holds best."""
        holding = self.limits.holding
        if abs(end - begin) <= NEAR:
            return ()
        straight = (slow_line(self.capsule, begin, end, holding),)
        if abs(begin) <= NEAR or abs(end) <= NEAR:
            return straight
        inward = slow_line(self.capsule, begin, 0j, holding)
        outward = slow_line(self.capsule, 0j, end, holding)
        return min(straight, (inward, outward), key=lambda way: sum(leg.duration for leg in way))
