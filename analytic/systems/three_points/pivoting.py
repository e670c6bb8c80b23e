"""Pivoting: one support rests and the body turns about it, until the turning stops or the support
slips.

With A_i at rest, two moments change the angular momentum about A_i: the slider's m (CQ - CA_i) x w,
and those of the two sliding supports, f N_j |A_iA_j| each against the turning. So omega is an
integral over time of known functions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from plumbob.analytic.numerics.collocation import evaluate
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.three_points.equations import Complex, Configuration, cross
from plumbob.analytic.systems.three_points.smooth_segment import (
    Interval,
    SmoothSegment,
    State,
    fitted,
    state_at,
)

SAMPLES = 129  # places in an element at which events are searched as changes of sign
ELEMENTS = 2000  # largest number of elements in one piece
UNBALANCED = 1e-3  # smallest unbalanced part of the moments as a pivot starts, over their size
ROUNDING = 1e-15  # rounding of omega over the largest change of omega by friction
SHORTEST = 1e-13  # shortest first element of a pivot, over the remaining time of the piece


Ending = Literal["time", "stop", "slip"]
STOP: Ending = "stop"


Pivoted = tuple[list[SmoothSegment], State, Ending]
"""The segments of a pivot, the state at its end, and the reason why it ended."""


@dataclass(frozen=True)
class Pivot:
    """A pivot about `support` during one piece of the slider's path. `sense` is the sign of the
    turning; it gives the direction of friction also when the angular velocity is 0."""

    interval: Interval
    support: int
    sense: float

    def inertia(self, at: Configuration) -> Array:
        """Moment of inertia about A_i [kg m^2], shape (n,)."""
        body = self.interval.body
        support = self.interval.body.supports[self.support]
        slider = body.mass * body.mass_ratio
        still = body.body_inertia + (body.mass - slider) * abs(support) ** 2
        return np.asarray(still + slider * np.abs(at.position - support) ** 2)

    def moment(self, at: Configuration) -> Array:
        """Moment of sliding friction about A_i [N m], shape (n,)."""
        supports = self.interval.body.supports
        return np.asarray(-self.sense * at.limits @ np.abs(supports - supports[self.support]))

    def motion(self, at: Configuration, omega: Array) -> tuple[Array, Complex]:
        """Returns d(omega)/dt [rad/s^2] while the body turns at `omega` [rad/s], shape (n,), and
        the friction force F_i [N] in body axes that keeps the support at rest."""
        body = self.interval.body
        mu = body.mass_ratio
        arm = at.position - body.supports[self.support]
        slider = body.mass * mu
        growth = 2.0 * slider * (arm.conjugate() * at.velocity).real
        moment = self.moment(at)
        rate = (moment - slider * cross(arm, at.acceleration) - growth * omega) / self.inertia(
            at
        )
        to_centre = -at.arms[:, self.support]
        acceleration = (1j * rate - omega**2) * to_centre + mu * (
            2j * omega * at.velocity + at.acceleration
        )
        levers = body.supports - body.supports[self.support]
        levers = levers / np.where(levers == 0.0, 1.0, np.abs(levers))
        others = -1j * self.sense * at.limits @ levers
        return rate, np.asarray(body.mass * acceleration - others)

    def margins(self, coefficients: Array, places: Array) -> tuple[Array, Array, Array]:
        """Returns three arrays of shape (n,) at `places` in [0, 1] of an element: the turning speed
        [rad/s], the margin of |F_i| below its limit [N], and that limit [N]. Each of the first two
        is positive until its event."""
        _, _, omega, time, *_ = evaluate(coefficients, places).T
        at = self.interval.at(time)
        needed = np.abs(self.motion(at, omega)[1])
        limit = at.limits[:, self.support]
        return self.sense * omega, limit - needed, limit


def pivot(turning: Pivot, state: State) -> Pivoted:
    """Integrates the turn about a support from `state` until the turning stops, the support slips,
    or the piece ends. Returns the segments, the last state and the reason.

    Raises RuntimeError if no element is short enough.
    """
    segments: list[SmoothSegment] = []
    interval = turning.interval
    duration = interval.piece.duration
    size = _first_size(turning, state, duration - state.time)
    while len(segments) < ELEMENTS:
        remaining = duration - state.time
        if remaining <= 0.0:
            return segments, state, "time"
        size = min(size, remaining)
        coefficients, truncation, rounding = _solved(turning, state, size)
        place, ending = 0.0, STOP
        if truncation <= interval.accuracy.tolerance:
            place, ending = _first_event(turning, coefficients, rounding)
        if place == 0.0 and ending == STOP and size > SHORTEST * min(remaining, 1.0):
            # The element is not accurate, or the turning stops before the first sample. If such a
            # short turn were skipped, a pivot could never begin from rest.
            size *= 0.5
            continue
        if truncation > interval.accuracy.tolerance:
            number = interval.number
            raise RuntimeError(f"no step is small enough at {state.time!r} s of piece {number}")
        reached = state_at(coefficients, place)
        end = duration if ending == "time" and size == remaining else reached.time
        if place > 0.0:
            covered = (interval, state.time, end, coefficients, place)
            segments.append(SmoothSegment("pivot", turning.support, *covered))
        state = replace(reached, time=end)
        if ending != "time":
            return segments, state, ending
        size *= 2.0
    raise RuntimeError(f"{ELEMENTS} elements did not finish piece {interval.number}")


def _first_size(turning: Pivot, state: State, remaining: float) -> float:
    """Returns the length of the first element [s]: the remaining time of the piece. If the piece
    has no end, it is more than the time in which friction stops the turning."""
    if np.isfinite(remaining):
        return remaining
    here = turning.interval.at(state.time)
    braking = abs(float(turning.moment(here)[0]))
    return 1.5 * abs(state.omega) * float(turning.inertia(here)[0]) / braking


def _solved(turning: Pivot, state: State, size: float) -> tuple[Array, float, float]:
    """Returns the coefficients of a SmoothSegment from `state` over `size` [s], their relative
    truncation error, and the rounding error of omega [rad/s]."""
    interval = turning.interval
    rule = interval.accuracy.rule
    here = interval.at(state.time)
    at = interval.at(state.time + size * rule.nodes)
    inertia = turning.inertia(at)
    # The angular momentum about the support gives omega.
    push = turning.motion(at, np.zeros(len(rule.nodes)))[0] * inertia
    omega = (turning.inertia(here) * state.omega + size * rule.integral @ push) / inertia
    # The support stuck with a speed of round-off: this velocity has a support speed of exactly 0.
    point = -1j * state.omega * complex(here.arms[0, turning.support])
    moved = -1j * omega * at.arms[:, turning.support] - point
    moved = np.column_stack([moved.real, moved.imag, omega - state.omega, size * rule.nodes])
    slopes: Array = np.asarray(np.linalg.solve(rule.integral, moved))
    gain = size * float((np.abs(turning.moment(at)) / inertia).max())
    rate = max(float(np.abs(omega).max()), UNBALANCED * gain, 1e-300)
    speed = rate * float(np.abs(here.arms).max())
    return (
        fitted(interval, replace(state, point=point), slopes),
        rule.truncation(slopes, np.array([speed, speed, rate, size])),
        ROUNDING * gain,
    )


def _first_event(turning: Pivot, coefficients: Array, rounding: float) -> tuple[float, Ending]:
    """Returns the place in [0, 1] of an element's first event, and the event: the turning stops,
    the support slips, or the element ends."""
    from scipy.optimize import brentq

    places = np.linspace(0.0, 1.0, SAMPLES)
    speed, reserve, limits = turning.margins(coefficients, places)
    events: list[tuple[float, Ending]] = [(1.0, "time")]
    roundings = rounding + 1e-14 * float(speed.max()), 1e-11 * float(limits[0])
    endings: tuple[Ending, Ending] = ("stop", "slip")
    for which, margins in enumerate((speed, reserve)):

        def margin(place: float, which: int = which) -> float:
            return float(turning.margins(coefficients, np.array([place]))[which][0])

        below = np.flatnonzero(margins < -roundings[which])
        if below.size:
            high = int(below[0])
            low = max(high - 1, 0)
            place = float(places[low])
            if margins[low] > 0.0:
                place = float(brentq(margin, place, places[high], xtol=1e-16, rtol=1e-15))
            events.append((place, endings[which]))
    return min(events)
