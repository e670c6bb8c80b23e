"""A smooth segment of motion in one mode, kept as polynomials, and the state between segments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from plumbob.analytic.numerics.collocation import Collocation, basis, evaluate
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.slider_path import Piece
from plumbob.analytic.systems.three_points.equations import Configuration, Mechanics, configuration

CLOSE = 1e-12  # Newton converges quadratically: the step after one this small is below round-off
NEWTON_STEPS = 8
BRACKETS = 64  # of a segment, to start Newton's method from
Mode = Literal["slide", "pivot", "rest"]
Indices = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Accuracy:
    """Discretisation: the collocation rule, and the relative truncation error of an element."""

    rule: Collocation
    tolerance: float


@dataclass(frozen=True)
class State:
    """State at local `time` [s] of a piece: velocity p of the body's point at G in body axes
    [m/s], angular velocity [rad/s], heading psi [rad], place of G on the ground [m]."""

    time: float
    point: complex
    omega: float
    heading: float
    place: complex


@dataclass(frozen=True)
class SmoothSegment:
    """One mode from local time `start` to `end` [s] of piece number `piece`; `support` is the one
    at rest in a pivot, or the one that slips as a slide begins, else -1.

    `coefficients`, shape (k, 7): p_x, p_y, omega, t, psi and the place of G as Legendre series in a
    parameter from 0 to `last`, at most 1. None while the body rests in its first state.
    """

    mode: Mode
    support: int
    piece: int
    start: float
    end: float
    first: State
    coefficients: Array | None = None
    last: float = 1.0


def states_of(segments: Sequence[SmoothSegment], which: Indices, times: Array) -> Array:
    """The seven quantities at local `times` [s], each of the segment with the number in `which`,
    shape (n,): shape (n, 7). The coefficients of all segments have the same shape."""
    every = np.array([segment.coefficients for segment in segments])
    last = np.array([segment.last for segment in segments])
    places = _roots(every[..., 3], which, times, last)
    values = basis(places, every.shape[1])
    return np.asarray(np.matmul(values[:, None], every[which])[:, 0])


def monotone_root(series: Array, values: Array, last: float = 1.0) -> Array:
    """Places in [0, last], shape (n,), where an increasing Legendre `series`, shape (k,), takes
    `values`, shape (n,)."""
    return _roots(series[None], np.zeros(len(values), dtype=np.int64), values, np.array([last]))


def _roots(series: Array, which: Indices, values: Array, last: Array) -> Array:
    """Places in [0, last] where increasing Legendre `series`, shape (m, k), `last` of shape (m,),
    take `values`, each of the series with the number in `which`, both of shape (n,), by Newton's
    method, bisecting where it would leave its bracket."""
    slopes = 2.0 * np.polynomial.legendre.legder(series, axis=1)
    low, high, ratio = _brackets(series, which, values, last)
    x = low + np.clip(ratio, 0.0, 1.0) * (high - low)
    clocks, paces = series[which], slopes[which]
    for _ in range(NEWTON_STEPS):
        at = basis(x, series.shape[1])
        excess = (at * clocks).sum(axis=1) - values
        low, high = np.where(excess < 0.0, x, low), np.where(excess > 0.0, x, high)
        rate = (at[:, :-1] * paces).sum(axis=1)
        step = x - excess / np.where(rate > 0.0, rate, np.inf)
        last_x, x = x, np.where((step >= low) & (step <= high), step, 0.5 * (low + high))
        if np.all(np.abs(x - last_x) <= CLOSE * last[which]):
            break
    return x


def _brackets(
    series: Array, which: Indices, values: Array, last: Array
) -> tuple[Array, Array, Array]:
    """Ends of the interval of a grid in which each root lies, and about where in it, 0 to 1."""
    grid = last[:, None] * np.linspace(0.0, 1.0, BRACKETS + 1)
    known = basis(grid.ravel(), series.shape[1]).reshape(*grid.shape, series.shape[1])
    heights = np.maximum.accumulate(np.matmul(known, series[..., None])[..., 0], axis=1)
    below = (heights[which] < values[:, None]).sum(axis=1)
    where = np.clip(below, 1, BRACKETS)
    rise = heights[which, where] - heights[which, where - 1]
    ratio = (values - heights[which, where - 1]) / np.where(rise > 0.0, rise, 1.0)
    return grid[which, where - 1], grid[which, where], ratio


def fitted(rule: Collocation, body: Mechanics, piece: Piece, first: State, slopes: Array) -> Array:
    """Coefficients of a SmoothSegment, shape (n + 1, 7), from the `slopes`, shape (n, 4), of (p_x,
    p_y, omega, t) at the nodes; heading and place of G follow by integration."""
    start = [first.point.real, first.point.imag, first.omega, first.time, first.heading]
    start += [first.place.real, first.place.imag]
    states = np.array(start[:4]) + rule.integral @ slopes
    turning = slopes[:, 3] * states[:, 2]
    heading = first.heading + rule.integral @ turning
    velocity = configuration(body, piece, states[:, 3]).velocity
    centre = states[:, 0] + 1j * states[:, 1] + body.mass_ratio * velocity
    drift = slopes[:, 3] * centre * np.exp(1j * heading)
    everything = np.column_stack([slopes, turning, drift.real, drift.imag])
    return rule.primitive(np.array(start), everything)


def state_at(coefficients: Array, place: float) -> State:
    """The state at parameter `place` of a segment's polynomials."""
    if place == 1.0:
        values = coefficients.sum(axis=0)
    else:
        values = evaluate(coefficients, np.array([place]))[0]
    px, py, omega, time, heading, x, y = values
    return State(float(time), complex(px, py), float(omega), float(heading), complex(x, y))


def at_rest(body: Mechanics, piece: Piece, time: float, heading: float, com: complex) -> State:
    """The state of a body at rest with its centre of mass at `com` on the ground [m]."""
    at = configuration(body, piece, np.array([time]))
    place = com + body.mass_ratio * complex(at.position[0]) * np.exp(1j * heading)
    return State(time, 0j, 0.0, heading, complex(place))


def com_of(body: Mechanics, piece: Piece, state: State) -> complex:
    """Place of C on the ground [m] in `state` of a `piece`."""
    at = configuration(body, piece, np.array([state.time]))
    arm = body.mass_ratio * complex(at.position[0]) * np.exp(1j * state.heading)
    return complex(state.place - arm)


def speed_scale(at: Configuration, state: State) -> float:
    """Size of the terms that add up to a support's velocity [m/s], for judging its round-off."""
    return abs(state.point) + abs(state.omega) * float(np.abs(at.arms).max())
