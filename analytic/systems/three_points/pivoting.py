"""Pivoting: one support at rest, the body turns about it, until it stops or the support slips.

With A_i at rest the angular momentum about it changes by the slider's m (CQ - CA_i) x w and by the
moments of the two sliding supports, f N_j |A_iA_j| each against the turning: omega is a plain
integral over time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from plumbob.analytic.numerics.collocation import evaluate
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.slider_path import Piece
from plumbob.analytic.systems.three_points.equations import (
    Complex,
    Configuration,
    Mechanics,
    configuration,
    cross,
)
from plumbob.analytic.systems.three_points.smooth_segment import (
    Accuracy,
    SmoothSegment,
    State,
    fitted,
    state_at,
)

SAMPLES = 129  # of an element, for changes of sign
ELEMENTS = 2000  # in one piece, before giving up
UNBALANCED = 1e-3  # smallest unbalanced part of the moments as a pivot starts, over their size
ROUNDING = 1e-15  # of the moments, in omega
SMALLEST = 1e-14  # element over what is left of the piece, before giving up
SHORTEST = 1e-13  # element over what is left of the piece: a shorter pivot does not begin


Ending = Literal["time", "stop", "slip"]


@dataclass(frozen=True)
class Pivoted:
    """Result of a pivot: its segments, the state at its end, and why it ended."""

    segments: list[SmoothSegment]
    state: State
    ending: Ending


@dataclass(frozen=True)
class PivotMotion:
    """The pivot at n times: d(omega)/dt [rad/s^2], p [m/s], and the friction force F_i [N] that
    keeps the support at rest, in body axes."""

    omega_rate: Array
    point: Complex
    needed_force: Complex


@dataclass(frozen=True)
class Pivot:
    """A pivot about `support` in the direction `sense`, the sign of the turning, which decides the
    friction where it has no rate, during one piece of the slider's path."""

    body: Mechanics
    piece: Piece
    support: int
    sense: float

    def at(self, times: Array) -> Configuration:
        return configuration(self.body, self.piece, times)

    def about(self, at: Configuration) -> tuple[Complex, Array]:
        """Slider from A_i [m] and moment of inertia about A_i [kg m^2], each of shape (n,)."""
        body, support = self.body, self.body.supports[self.support]
        arm = at.position - support
        slider = body.mass * body.mass_ratio
        inertia = body.body_inertia + (body.mass - slider) * abs(support) ** 2
        return arm, inertia + slider * np.abs(arm) ** 2

    def moment(self, at: Configuration) -> Array:
        """Moment about A_i of sliding friction [N m], shape (n,)."""
        supports = self.body.supports
        return np.asarray(-self.sense * at.limits @ np.abs(supports - supports[self.support]))

    def motion(self, at: Configuration, omega: Array) -> PivotMotion:
        """Motion, and the friction force at the support at rest, while the body turns at `omega`
        [rad/s], shape (n,)."""
        body, mu = self.body, self.body.mass_ratio
        (arm, inertia), slider = self.about(at), body.mass * mu
        growth = 2.0 * slider * (arm.conjugate() * at.velocity).real
        moment = self.moment(at)
        rate = (moment - slider * cross(arm, at.acceleration) - growth * omega) / inertia
        to_centre = -at.arms[:, self.support]
        acceleration = (1j * rate - omega**2) * to_centre + mu * (
            2j * omega * at.velocity + at.acceleration
        )
        levers = body.supports - body.supports[self.support]
        levers = levers / np.where(levers == 0.0, 1.0, np.abs(levers))
        others = -1j * self.sense * at.limits @ levers
        return PivotMotion(rate, 1j * omega * to_centre, body.mass * acceleration - others)

    def margins(self, coefficients: Array, places: Array) -> tuple[Array, Array]:
        """Turning speed [rad/s] and how far |F_i| is below its limit [N] at `places` of an element,
        shape (n,): each is positive until its event."""
        _, _, omega, time, *_ = evaluate(coefficients, places).T
        at = self.at(time)
        needed = np.abs(self.motion(at, omega).needed_force)
        return self.sense * omega, at.limits[:, self.support] - needed


@dataclass(frozen=True)
class _Element:
    """Coefficients of a SmoothSegment over `size` [s], their relative truncation error, and the
    rounding of omega [rad/s]."""

    size: float
    coefficients: Array
    truncation: float
    rounding: float


@dataclass(frozen=True)
class _Event:
    """The first event in an element: its place in [0, 1] and what happens there."""

    place: float
    ending: Ending


def pivot(
    turning: Pivot, number: int, duration: float, state: State, accuracy: Accuracy
) -> Pivoted:
    """Turn about a support from `state` until the turning stops, the support slips, or `duration`
    [s] of piece `number` is over.

    Raises RuntimeError if no step is small enough.
    """
    segments: list[SmoothSegment] = []
    size = _first_size(turning, state, duration - state.time)
    while len(segments) < ELEMENTS:
        remaining = duration - state.time
        if remaining <= 0.0:
            return Pivoted(segments, state, "time")
        smallest = SMALLEST * min(remaining, 1.0)
        element = _element(turning, accuracy, state, min(size, remaining), smallest, number)
        size, event = element.size, _first_event(turning, element, state)
        if event == _Event(0.0, "stop") and size > SHORTEST * min(remaining, 1.0):
            # It turns and stops before the first sample, or from rest it would never begin.
            size *= 0.5
            continue
        reached = state_at(element.coefficients, event.place)
        end = duration if event.ending == "time" and size == remaining else reached.time
        if event.place > 0.0:
            segments.append(_segment(turning, number, state.time, end, element, event.place))
        state = replace(reached, time=end)
        if event.ending != "time":
            return Pivoted(segments, state, event.ending)
        size *= 2.0
    raise RuntimeError(f"{ELEMENTS} elements did not finish piece {number}")


def _first_size(turning: Pivot, state: State, remaining: float) -> float:
    """Length of the first element [s]: the rest of the piece or, where that has no end, more than
    friction needs to stop the turning."""
    if np.isfinite(remaining):
        return remaining
    here = turning.at(np.array([state.time]))
    braking = abs(float(turning.moment(here)[0]))
    return 1.5 * abs(state.omega) * float(turning.about(here)[1][0]) / braking


def _element(
    turning: Pivot, accuracy: Accuracy, state: State, size: float, smallest: float, number: int
) -> _Element:
    """The element from `state` of `size` [s], halved until its truncation error is within the
    tolerance. Raises RuntimeError where it would be below `smallest` [s]."""
    while True:
        element = _solved(turning, accuracy, state, size)
        if element.truncation <= accuracy.tolerance:
            return element
        size *= 0.5
        if size < smallest:
            raise RuntimeError(f"no step is small enough at {state.time!r} s of piece {number}")


def _solved(turning: Pivot, accuracy: Accuracy, state: State, size: float) -> _Element:
    """The element from `state` over `size` [s]."""
    rule, here = accuracy.rule, turning.at(np.array([state.time]))
    at = turning.at(state.time + size * rule.nodes)
    (arm, inertia), moment = turning.about(at), turning.moment(at)
    # From the angular momentum about the support.
    omega = moment - turning.body.mass * turning.body.mass_ratio * cross(arm, at.acceleration)
    omega = (turning.about(here)[1] * state.omega + size * rule.integral @ omega) / inertia
    motion = turning.motion(at, omega)
    # The round-off speed that the support had as it stuck is set to zero here.
    point = -1j * state.omega * complex(here.arms[0, turning.support])
    moved = motion.point - point
    values = np.column_stack([moved.real, moved.imag, omega - state.omega, size * rule.nodes])
    slopes: Array = np.asarray(np.linalg.solve(rule.integral, values))
    gain = size * float((np.abs(moment) / inertia).max())
    rate = max(float(np.abs(omega).max()), UNBALANCED * gain, 1e-300)
    speed = rate * float(np.abs(here.arms).max())
    return _Element(
        size,
        fitted(rule, turning.body, turning.piece, replace(state, point=point), slopes),
        rule.truncation(slopes, np.array([speed, speed, rate, size])),
        ROUNDING * gain,
    )


def _first_event(turning: Pivot, element: _Element, state: State) -> _Event:
    """The first event of an element that begins at `state`: the turning stops, the support slips,
    or neither."""
    places = np.linspace(0.0, 1.0, SAMPLES)
    speed, reserve = turning.margins(element.coefficients, places)
    limits = turning.at(np.array([state.time])).limits
    events = [_Event(1.0, "time")]
    rules: tuple[tuple[Ending, int, Array, float], ...] = (
        ("stop", 0, speed, element.rounding + 1e-14 * float(speed.max())),
        ("slip", 1, reserve, 1e-11 * float(limits.max())),
    )
    for ending, which, values, rounding in rules:

        def margin(place: float, which: int = which) -> float:
            return float(turning.margins(element.coefficients, np.array([place]))[which][0])

        place = _crossing(margin, places, values, rounding)
        if place is not None:
            events.append(_Event(place, ending))
    return min(events, key=lambda event: (event.place, event.ending))


def _crossing(
    margin: Callable[[float], float], places: Array, values: Array, rounding: float
) -> float | None:
    """The first place at which `margin`, sampled as `values` at `places`, falls below zero by more
    than `rounding`; None where it does not."""
    from scipy.optimize import brentq

    below = np.flatnonzero(values < -rounding)
    if not below.size:
        return None
    high = int(below[0])
    low = max(high - 1, 0)
    if not values[low] > 0.0:
        return float(places[low])
    return float(brentq(margin, places[low], places[high], xtol=1e-16, rtol=1e-15))


def _segment(
    turning: Pivot, number: int, begin: float, end: float, element: _Element, last: float
) -> SmoothSegment:
    """The part of an element from local time `begin` to `end` [s], up to the place `last`."""
    return SmoothSegment("pivot", turning.support, number, begin, end, element.coefficients, last)
