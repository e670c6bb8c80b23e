"""A smooth segment of motion in one mode, stored as polynomials, and the state between segments."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from plumbob.analytic.numerics.collocation import Collocation, basis, evaluate
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.slider_path import Piece
from plumbob.analytic.systems.three_points.equations import (
    ComplexForces,
    Configuration,
    Mechanics,
    configuration,
)

# size of the last Newton step: convergence is quadratic, so the next step would be round-off
LAST_NEWTON_STEP = 1e-9
MAX_SEGMENT_NEWTON_STEPS = 8
BRACKETS = 64  # intervals of a segment in which Newton's method starts
Mode = Literal["slide", "pivot", "rest"]


@dataclass(frozen=True)
class Accuracy:
    """The discretisation: the collocation rule, and the tolerance on the relative truncation error
    of an element."""

    rule: Collocation
    tolerance: float


@dataclass(frozen=True)
class Interval:
    """The time during which the slider follows the piece number `number` of its path."""

    body: Mechanics
    piece: Piece
    number: int
    accuracy: Accuracy

    def at(self, times: float | Array) -> Configuration:
        """Returns the slider's terms in the equations at local `times` [s], shape (n,), or at one
        time."""
        return configuration(self.body, self.piece, np.atleast_1d(times))


@dataclass(frozen=True)
class SegmentState:
    """State at local `time` [s] of a piece: velocity p of the body's point at G in body axes [m/s],
    angular velocity [rad/s], heading psi [rad], position of C on the ground [m]."""

    time: float
    velocity: complex
    omega: float
    heading: float
    place: complex

    @property
    def row(self) -> Array:
        """The array (p_x, p_y, omega, t), shape (4,)."""
        return np.array([self.velocity.real, self.velocity.imag, self.omega, self.time])


@dataclass(frozen=True)
class SmoothSegment:
    """One mode from local time `start` to `end` [s] of an `interval`. `support` is the support at
    rest in a pivot, or the support that slips as a slide begins, else -1.

    `coefficients`, shape (k, 7), are Legendre series of p_x, p_y, omega, t, psi and the two
    coordinates of C, in a parameter from 0 to `last`, which is at most 1.
    """

    mode: Mode
    support: int
    interval: Interval
    start: float
    end: float
    coefficients: Array
    last: float = 1.0

    def states(self, times: Array) -> Array:
        """Returns p_x, p_y, omega, t, psi and the coordinates of C at local `times` [s], shape
        (n,): shape (n, 7)."""
        parameters = monotone_root(self.coefficients[:, 3], times)
        return np.asarray(basis(parameters, len(self.coefficients)) @ self.coefficients)


def rest_segment(interval: Interval, end: float, state: SegmentState) -> SmoothSegment:
    """Returns the segment of a body at rest from `state` to local time `end` [s], which may be
    infinite."""
    half = 0.5 * (end - state.time if np.isfinite(end) else 1.0)
    coefficients = np.zeros((2, 7))
    coefficients[0, 3:] = state.time + half, state.heading, state.place.real, state.place.imag
    coefficients[1, 3] = half
    return SmoothSegment(
        mode="rest",
        support=-1,
        interval=interval,
        start=state.time,
        end=end,
        coefficients=coefficients,
    )


@lru_cache(maxsize=8)
def _grid(count: int) -> tuple[Array, Array]:
    """Returns the BRACKETS + 1 grid points in [0, 1], and the first `count` polynomials there."""
    points = np.linspace(0.0, 1.0, BRACKETS + 1)
    return points, basis(points, count)


def monotone_root(series: Array, values: Array) -> Array:
    """Returns the parameters in [0, 1], shape (n,), at which an increasing Legendre `series`, shape
    (k,), has the `values`, shape (n,). Newton's method searches within one interval of a grid."""
    grid, polynomials = _grid(len(series))
    grid_values = np.maximum.accumulate(polynomials @ series)
    upper = np.clip(np.searchsorted(grid_values, values), 1, BRACKETS)
    derivative = 2.0 * np.polynomial.legendre.legder(series)
    parameters = np.interp(values, grid_values, grid)
    for _ in range(MAX_SEGMENT_NEWTON_STEPS):
        polynomials = basis(parameters, len(series))
        rate = polynomials[:, :-1] @ derivative
        step = (polynomials @ series - values) / np.where(rate > 0.0, rate, np.inf)
        parameters = np.clip(parameters - step, grid[upper - 1], grid[upper])
        if np.all(np.abs(step) <= LAST_NEWTON_STEP):
            break
    return parameters


def fitted_coefficients(interval: Interval, first: SegmentState, slopes: Array) -> Array:
    """Returns the coefficients of a SmoothSegment, shape (n + 1, 7), that begins at the state
    `first` and has the `slopes` of (p_x, p_y, omega, t) at the nodes, shape (n, 4). Heading and
    position of C follow by integration."""
    rule = interval.accuracy.rule
    start = np.array([*first.row, first.heading, first.place.real, first.place.imag])
    states = start[:4] + rule.integral @ slopes
    turning = slopes[:, 3] * states[:, 2]
    heading = first.heading + rule.integral @ turning
    slider = interval.at(states[:, 3]).position
    moving = slopes[:, 3] * velocity_of_c(interval.body, slider, states) * np.exp(1j * heading)
    return rule.primitive(start, np.column_stack([slopes, turning, moving.real, moving.imag]))


def velocity_of_c(body: Mechanics, slider: ComplexForces, states: Array) -> ComplexForces:
    """Returns the velocity of C in body axes [m/s], shape (n,), from the `slider`'s position r [m],
    shape (n,), and `states` (p_x, p_y, omega, ...), shape (n, 3 or more)."""
    velocity = states[:, 0] + 1j * states[:, 1]
    omega = states[:, 2]
    return np.asarray(velocity - 1j * omega * body.mass_ratio * slider)


def state_at(coefficients: Array, parameter: float) -> SegmentState:
    """Returns the state at a `parameter` of a segment's polynomials."""
    if parameter == 1.0:
        values = coefficients.sum(axis=0)
    else:
        values = evaluate(coefficients, np.array([parameter]))[0]
    px, py, omega, time, heading, x, y = values
    return SegmentState(
        float(time), complex(px, py), float(omega), float(heading), complex(x, y)
    )


def speed_scale(terms: Configuration, state: SegmentState) -> float:
    """Returns the size of the terms that add up to a support's velocity [m/s]: the scale of its
    round-off."""
    return abs(state.velocity) + abs(state.omega) * float(np.abs(terms.arms).max())
