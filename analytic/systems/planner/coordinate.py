"""A plan on the single curve as the motion of one coordinate, the arc length along it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.planner.result import Plan
from plumbob.analytic.systems.planner.tracks import NEAR, Curve
from plumbob.analytic.systems.slider_path import ArcPiece, StraightPiece


@dataclass(frozen=True)
class CurveMotion:
    """The slider's arc length along the curve [m]: C-Ai, the circle, C-Aj back to C.

    `begins` [s], shape (n+1,), when each piece begins and the last one ends; `places` [m], `rates`
    [m/s] and `accelerations` [m/s^2] there, shape (n+1,), each acceleration lasting for its piece.
    """

    curve: Curve
    begins: Array
    places: Array
    rates: Array
    accelerations: Array

    def _pieces(self, times: Array) -> tuple[Array, Array, Array, Array]:
        which = np.searchsorted(self.begins, times, side="right") - 1
        elapsed = np.asarray(times) - self.begins[which]
        return elapsed, self.places[which], self.rates[which], self.accelerations[which]

    def place(self, times: Array) -> Array:
        """The coordinate [m] at `times` [s], shape (n,)."""
        elapsed, place, rate, acceleration = self._pieces(times)
        return np.asarray(place + elapsed * (rate + 0.5 * acceleration * elapsed))

    def rate(self, times: Array) -> Array:
        """Its rate [m/s] at `times` [s], shape (n,)."""
        elapsed, _, rate, acceleration = self._pieces(times)
        return np.asarray(rate + acceleration * elapsed)

    def mean_acceleration(self, edges: Array) -> Array:
        """Mean of its second derivative over each step between `edges` [s], shape (n+1,): shape
        (n,) [m/s^2]."""
        return np.diff(self.rate(edges)) / np.diff(edges)

    def slider(self, times: Array) -> Array:
        """The slider's place relative to C [m], shape (n, 2), at `times` [s], shape (n,)."""
        points = np.array([self.curve.point(float(place)) for place in self.place(times)])
        return np.column_stack([points.real, points.imag])


def _pace(curve: Curve, piece: StraightPiece | ArcPiece) -> tuple[float, float]:
    """Rate and acceleration of the coordinate as `piece` begins [m/s, m/s^2]."""
    if isinstance(piece, ArcPiece):
        forward = math.copysign(piece.radius, curve.swing)
        return forward * piece.rate, forward * piece.acceleration
    first = math.cos(piece.direction - curve.first)
    second = math.cos(piece.direction - curve.first - curve.swing)
    forward = math.copysign(1.0, first if abs(first) > abs(second) else -second)
    return forward * piece.speed, forward * piece.acceleration


def along_curve(plan: Plan) -> CurveMotion:
    """The motion of the coordinate in a `plan` on the track "curve"."""
    curve, path = Curve(plan.capsule, plan.limits, plan.legs, plan.arc), plan.path
    paces = [
        _pace(curve, piece) for piece in path.pieces if isinstance(piece, (StraightPiece, ArcPiece))
    ]
    lasting = np.diff(path.breakpoints)
    rates, accelerations = np.array(paces).T
    ways = lasting * (rates + 0.5 * accelerations * lasting)
    moving = ways[np.abs(ways) > NEAR]
    ends = sorted(place.real for place in curve.places(plan.start.slider))
    begin = ends[-1] if moving.size and moving[0] < 0.0 else ends[0]
    return CurveMotion(
        curve,
        path.breakpoints,
        begin + np.concatenate([[0.0], np.cumsum(ways)]),
        np.append(rates, 0.0),
        np.append(accelerations, 0.0),
    )
