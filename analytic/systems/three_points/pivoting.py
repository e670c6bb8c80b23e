"""Pivoting: one support rests and the body turns about it, until the turning stops or the support
slips.

With A_i at rest, two moments change the angular momentum about A_i: the slider's m (CQ - CA_i) x w,
and those of the two sliding supports, f N_j |A_iA_j| each against the turning. So omega is an
integral over time of known functions.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from plumbob.analytic.numerics.collocation import evaluate
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.three_points.equations import ComplexForces, Configuration, cross
from plumbob.analytic.systems.three_points.smooth_segment import (
    Interval,
    SegmentState,
    SmoothSegment,
    fitted_coefficients,
    state_at,
)

EVENT_SAMPLES = 129  # places in an element at which events are searched as changes of sign
MAX_PIVOT_ELEMENTS = 2000  # largest number of elements in one piece
# Smallest unbalanced part of the moments as a pivot starts, as a fraction of their size
UNBALANCED_MOMENT = 1e-3
OMEGA_ROUNDING = 1e-15  # ratio of omega's rounding to the largest change of omega by friction
# Shortest first element of a pivot, as a fraction of the remaining time of the piece
SHORTEST_PART = 1e-13


Ending = Literal["time", "stop", "slip"]
STOP: Ending = "stop"


Pivoted = tuple[list[SmoothSegment], SegmentState, Ending]
"""The segments of a pivot, the state at its end, and the reason why it ended."""


@dataclass(frozen=True)
class Pivot:
    """A pivot about `support` during one piece of the slider's path. `sense` is the sign of the
    turning; it gives the direction of friction also when the angular velocity is 0."""

    interval: Interval
    support: int
    sense: float

    def inertia(self, terms: Configuration) -> Array:
        """Moment of inertia about A_i [kg m^2], shape (n,)."""
        body = self.interval.body
        support = body.supports[self.support]
        slider_mass = body.mass * body.mass_ratio
        body_mass = body.mass - slider_mass
        constant = body.body_inertia + body_mass * abs(support) ** 2
        return np.asarray(constant + slider_mass * np.abs(terms.position - support) ** 2)

    def moment(self, terms: Configuration) -> Array:
        """Moment of sliding friction about A_i [N m], shape (n,)."""
        supports = self.interval.body.supports
        return np.asarray(
            -self.sense * terms.limits @ np.abs(supports - supports[self.support])
        )

    def motion(self, terms: Configuration, omega: Array) -> tuple[Array, ComplexForces]:
        """Returns d(omega)/dt [rad/s^2] while the body turns at `omega` [rad/s], shape (n,), and
        the friction force F_i [N] in body axes that keeps the support at rest."""
        body = self.interval.body
        mu = body.mass_ratio
        arm = terms.position - body.supports[self.support]
        slider_mass = body.mass * mu
        coriolis = 2.0 * slider_mass * (arm.conjugate() * terms.velocity).real * omega
        reaction = slider_mass * cross(arm, terms.acceleration)
        rate = (self.moment(terms) - reaction - coriolis) / self.inertia(terms)
        to_centre = -terms.arms[:, self.support]
        relative_acceleration = 2j * omega * terms.velocity + terms.acceleration
        acceleration = (1j * rate - omega**2) * to_centre + mu * relative_acceleration
        levers = body.supports - body.supports[self.support]
        levers = levers / np.where(levers == 0.0, 1.0, np.abs(levers))
        other_friction = -1j * self.sense * terms.limits @ levers
        return rate, np.asarray(body.mass * acceleration - other_friction)

    def margins(self, coefficients: Array, parameters: Array) -> tuple[Array, Array, Array]:
        """Returns three arrays of shape (n,) at `parameters` in [0, 1] of an element: the turning
        speed [rad/s], the margin of |F_i| below its limit [N], and that limit [N]. The turning
        stops when the speed falls to zero, and the support slips when the margin does."""
        _, _, omega, time, *_ = evaluate(coefficients, parameters).T
        terms = self.interval.at(time)
        needed = np.abs(self.motion(terms, omega)[1])
        limit = terms.limits[:, self.support]
        return self.sense * omega, limit - needed, limit


def integrate_pivot(pivot: Pivot, state: SegmentState) -> Pivoted:
    """Integrates the turn about a support from `state` until the turning stops, the support slips,
    or the piece ends. Returns the segments, the last state and the reason.

    Raises RuntimeError if no element is short enough to be accurate, or if MAX_PIVOT_ELEMENTS
    elements do not reach the end.
    """
    segments: list[SmoothSegment] = []
    interval = pivot.interval
    duration = interval.piece.duration
    size = _first_size(pivot, state, duration - state.time)
    while len(segments) < MAX_PIVOT_ELEMENTS:
        remaining = duration - state.time
        if remaining <= 0.0:
            return segments, state, "time"
        size = min(size, remaining)
        coefficients, truncation, rounding = _element(pivot, state, size)
        parameter, ending = 0.0, STOP
        if truncation <= interval.accuracy.tolerance:
            parameter, ending = _first_event(pivot, coefficients, rounding)
        stops_at_once = parameter == 0.0 and ending == STOP
        if stops_at_once and size > SHORTEST_PART * min(remaining, 1.0):
            # The element is not accurate, or the turning stops before the first sample. If such a
            # short turn were skipped, a pivot could never begin from rest.
            size *= 0.5
            continue
        if truncation > interval.accuracy.tolerance:
            place = f"{state.time!r} s of piece {interval.number}"
            raise RuntimeError(f"no step is small enough at {place}")
        last_state = state_at(coefficients, parameter)
        end = duration if ending == "time" and size == remaining else last_state.time
        if parameter > 0.0:
            segments.append(
                SmoothSegment(
                    mode="pivot",
                    support=pivot.support,
                    interval=interval,
                    start=state.time,
                    end=end,
                    coefficients=coefficients,
                    last=parameter,
                )
            )
        state = replace(last_state, time=end)
        if ending != "time":
            return segments, state, ending
        size *= 2.0
    raise RuntimeError(f"{MAX_PIVOT_ELEMENTS} elements did not finish piece {interval.number}")


def _first_size(pivot: Pivot, state: SegmentState, remaining: float) -> float:
    """Returns the length of the first element [s]: the remaining time of the piece. If the piece
    has no end, it is more than the time in which friction stops the turning."""
    if np.isfinite(remaining):
        return remaining
    terms = pivot.interval.at(state.time)
    braking = abs(float(pivot.moment(terms)[0]))
    return 1.5 * abs(state.omega) * float(pivot.inertia(terms)[0]) / braking


def _element(pivot: Pivot, state: SegmentState, size: float) -> tuple[Array, float, float]:
    """Returns the coefficients of a SmoothSegment from `state` over `size` [s], their relative
    truncation error, and the rounding error of omega [rad/s]."""
    interval = pivot.interval
    rule = interval.accuracy.rule
    first_terms = interval.at(state.time)
    terms = interval.at(state.time + size * rule.nodes)
    inertia = pivot.inertia(terms)
    # The angular momentum about the support gives omega.
    moment = pivot.motion(terms, np.zeros(len(rule.nodes)))[0] * inertia
    omega = (pivot.inertia(first_terms) * state.omega + size * rule.integral @ moment) / inertia
    # The support stuck with a speed of round-off: this velocity has a support speed of exactly 0.
    velocity = -1j * state.omega * complex(first_terms.arms[0, pivot.support])
    change = -1j * omega * terms.arms[:, pivot.support] - velocity
    changes = [change.real, change.imag, omega - state.omega, size * rule.nodes]
    slopes: Array = np.asarray(np.linalg.solve(rule.integral, np.column_stack(changes)))
    friction_gain = size * float((np.abs(pivot.moment(terms)) / inertia).max())
    rate = max(float(np.abs(omega).max()), UNBALANCED_MOMENT * friction_gain, 1e-300)
    speed = rate * float(np.abs(first_terms.arms).max())
    truncation = rule.truncation(slopes, np.array([speed, speed, rate, size]))
    return (
        fitted_coefficients(interval, replace(state, velocity=velocity), slopes),
        truncation,
        OMEGA_ROUNDING * friction_gain,
    )


def _first_event(pivot: Pivot, coefficients: Array, rounding: float) -> tuple[float, Ending]:
    """Returns the parameter in [0, 1] of an element's first event, and the event: the turning
    stops, the support slips, or the element ends. `rounding` is the error of omega [rad/s]."""
    parameters = np.linspace(0.0, 1.0, EVENT_SAMPLES)
    speed, reserve, limits = pivot.margins(coefficients, parameters)
    # A margin below zero by no more than these errors does not count as an event.
    speed_error = rounding + 1e-14 * float(speed.max())
    force_error = 1e-11 * float(limits[0])

    def turning_speed(parameter: float) -> float:
        """Returns the turning speed [rad/s] at one parameter."""
        return float(pivot.margins(coefficients, np.array([parameter]))[0][0])

    def force_reserve(parameter: float) -> float:
        """Returns the margin of the support's friction below its limit [N] at one parameter."""
        return float(pivot.margins(coefficients, np.array([parameter]))[1][0])

    stop = _first_zero(turning_speed, parameters, speed, speed_error)
    slip = _first_zero(force_reserve, parameters, reserve, force_error)
    events: tuple[tuple[float, Ending], ...] = ((stop, "stop"), (slip, "slip"), (1.0, "time"))
    return min(events)


def _first_zero(
    margin: Callable[[float], float], parameters: Array, samples: Array, error: float
) -> float:
    """Returns the first parameter at which a `margin` falls to zero; infinite if it does not fall
    below -`error` at any of the `parameters`, where it has the values `samples`, shape (n,)."""
    from scipy.optimize import brentq

    below = np.flatnonzero(samples < -error)
    if not below.size:
        return math.inf
    high = int(below[0])
    low = max(high - 1, 0)
    if samples[low] <= 0.0:
        return float(parameters[low])
    return float(
        brentq(margin, float(parameters[low]), parameters[high], xtol=1e-16, rtol=1e-15)
    )
