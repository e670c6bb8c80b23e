"""Pivoting: one support at rest, the body turns about it, until it stops or the support slips.

With A_i at rest the angular momentum about it changes by the slider's m (CQ - CA_i) x w and by the
moments of the two sliding supports, f N_j |A_iA_j| each against the turning: on level ground omega
is a plain integral over time.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.slider_path import Piece
from plumbob.analytic.systems.three_points.collocation import Scheme, evaluate, tail
from plumbob.analytic.systems.three_points.element import Accuracy
from plumbob.analytic.systems.three_points.equations import (
    Complex,
    Configuration,
    Mechanics,
    configuration,
    cross,
)
from plumbob.analytic.systems.three_points.smooth_segment import (
    SmoothSegment,
    State,
    fitted,
    state_at,
)

SAMPLES = 129  # of an element, for changes of sign
HEADING_PASSES = 40
ELEMENTS = 2000
ROUGH = (
    1e-3  # speed gained by the least unbalanced start, over what its balanced moments would give
)
ROUNDING = 1e-15
SHORTEST = 1e-13  # element over what is left of the piece: a pivot shorter than that is none


Ending = Literal["time", "stop", "slip"]


@dataclass(frozen=True)
class Pivoted:
    """What a pivot came to: its segments, the state at its end, and why it ended."""

    segments: list[SmoothSegment]
    state: State
    ending: Ending


@dataclass(frozen=True)
class PivotMotion:
    """The pivot at n times: d(omega)/dt [rad/s^2], p [m/s], and the force F_i [N], body axes, that
    keeps the support in its place."""

    omega_rate: Array
    point: Complex
    share: Complex


@dataclass(frozen=True)
class _Element:
    """Coefficients of a SmoothSegment, what its degree leaves out, relatively, and rounding of omega."""

    coefficients: Array
    left_out: float
    rounding: float


def _about(body: Mechanics, at: Configuration, support: int) -> tuple[Complex, Array]:
    """Slider from A_i [m] and moment of inertia about A_i [kg m^2], each of shape (n,)."""
    arm = at.position - body.supports[support]
    slider = body.mass * body.mass_ratio
    own = body.body_inertia + (body.mass - slider) * abs(body.supports[support]) ** 2
    return arm, own + slider * np.abs(arm) ** 2


def _moment(
    body: Mechanics, at: Configuration, support: int, sense: float, heading: Array
) -> Array:
    """Moment about A_i of sliding friction and slope [N m], shape (n,)."""
    distances = np.abs(body.supports - body.supports[support])
    moment = -sense * at.limits @ distances
    if body.tilt:
        pull = body.mass * body.tilt * np.exp(-1j * heading)
        moment = moment - cross(at.arms[:, support], pull)
    return np.asarray(moment)


def pivot_motion(
    body: Mechanics, at: Configuration, support: int, sense: float, omega: Array, heading: Array
) -> PivotMotion:
    """Motion and held support's force while the body turns at `omega` [rad/s], shape (n,), about
    `support`; `sense` is the sign of the turning, which decides the friction where omega is 0."""
    arm, inertia = _about(body, at, support)
    slider = body.mass * body.mass_ratio
    growth = 2.0 * slider * (arm.conjugate() * at.velocity).real
    moment = _moment(body, at, support, sense, heading)
    rate = (moment - slider * cross(arm, at.acceleration) - growth * omega) / inertia
    to_centre, mu = -at.arms[:, support], body.mass_ratio
    acceleration = (1j * rate - omega**2) * to_centre + mu * (
        2j * omega * at.velocity + at.acceleration
    )
    levers = body.supports - body.supports[support]
    levers = levers / np.where(levers == 0.0, 1.0, np.abs(levers))
    others = -1j * sense * at.limits @ levers
    pull = body.mass * body.tilt * np.exp(-1j * heading)
    share = body.mass * acceleration - others - pull
    return PivotMotion(rate, 1j * omega * to_centre, share)


def _element(
    body: Mechanics,
    piece: Piece,
    support: int,
    sense: float,
    state: State,
    rule: Scheme,
    size: float,
) -> _Element:
    here = configuration(body, piece, np.array([state.time]))
    turning = _about(body, here, support)[1] * state.omega
    at = configuration(body, piece, state.time + size * rule.nodes)
    arm, inertia = _about(body, at, support)
    driving = -body.mass * body.mass_ratio * cross(arm, at.acceleration)
    heading = np.full(rule.nodes.size, state.heading)
    for _ in range(HEADING_PASSES if body.tilt else 1):
        moment = _moment(body, at, support, sense, heading)
        omega = (turning + size * rule.integrals @ (driving + moment)) / inertia
        before, heading = heading, state.heading + size * rule.integrals @ omega
        if np.abs(heading - before).max() <= 1e-15:
            break
    motion = pivot_motion(body, at, support, sense, omega, heading)
    # What little speed the support had left when it stuck is dropped here.
    point = -1j * state.omega * complex(here.arms[0, support])
    start = replace(state, point=point)
    moved = motion.point - point, omega - state.omega
    values = np.column_stack([moved[0].real, moved[0].imag, moved[1], size * rule.nodes])
    slopes: Array = np.asarray(np.linalg.solve(rule.integrals, values))
    jolt = size * float((np.abs(moment) / inertia).max())
    spread = max(float(np.abs(omega).max()), ROUGH * jolt, 1e-300)
    reach = spread * float(np.abs(here.arms).max())
    scale = np.array([reach, reach, spread, size])
    return _Element(
        fitted(rule, body, piece, start, slopes), tail(rule, slopes, scale), ROUNDING * jolt
    )


def pivot(
    body: Mechanics,
    piece: Piece,
    number: int,
    duration: float,
    state: State,
    support: int,
    sense: float,
    accuracy: Accuracy,
) -> Pivoted:
    """Turn about `support` in the direction `sense` from `state` until the turning stops, the
    support slips, or `duration` [s] of piece `number` is over.

    Raises RuntimeError if no step is small enough.
    """
    rule, segments = accuracy.rule, list[SmoothSegment]()
    size = 0.0
    while len(segments) < ELEMENTS:
        remaining = duration - state.time
        if remaining <= 0.0:
            return Pivoted(segments, state, "time")
        here = configuration(body, piece, np.array([state.time]))
        if size == 0.0:
            size = remaining
            if not np.isfinite(remaining):
                inertia = _about(body, here, support)[1]
                braking = abs(float(_moment(body, here, support, sense, np.zeros(1))[0]))
                size = 1.5 * abs(state.omega) * float(inertia[0]) / braking
        size = min(size, remaining)
        while True:
            element = _element(body, piece, support, sense, state, rule, size)
            if element.left_out <= accuracy.tolerance:
                break
            size *= 0.5
            if size < 1e-14 * min(remaining, 1.0):
                raise RuntimeError(f"no step is small enough at {state.time!r} s of piece {number}")

        coefficients = element.coefficients

        def watched(places: Array, series: Array = coefficients) -> tuple[Array, Array]:
            """Turning speed, and how far |F_i| is below its limit: an event is a change of sign."""
            _, _, omega, time, heading, *_ = evaluate(series, places).T
            at = configuration(body, piece, time)
            motion = pivot_motion(body, at, support, sense, omega, heading)
            return sense * omega, at.limits[:, support] - np.abs(motion.share)

        places = np.linspace(0.0, 1.0, SAMPLES)
        turning, margin = watched(places)
        floors = (element.rounding + 1e-14 * turning.max(), 1e-11 * here.limits.max())
        found: list[tuple[float, Ending]] = [(1.0, "time")]
        endings: tuple[Ending, Ending] = ("stop", "slip")
        for which, values in enumerate((turning, margin)):
            below = np.flatnonzero(values < -floors[which])
            if below.size:
                k = int(below[0])
                low = max(k - 1, 0)
                place = float(places[low])
                if values[low] > 0.0:
                    place = brentq(
                        lambda x, which=which: float(watched(np.array([x]))[which][0]),
                        *(places[low], places[k]),
                        xtol=1e-16,
                        rtol=1e-15,
                    )
                found.append((place, endings[which]))
        place, ending = min(found)
        if ending == "stop" and place == 0.0 and size > SHORTEST * min(remaining, 1.0):
            # It turns and stops before the first sample, or from rest it would never begin.
            size *= 0.5
            continue
        reached = state_at(coefficients, place)
        end = duration if ending == "time" and size == remaining else reached.time
        if place > 0.0:
            first = state_at(coefficients, 0.0)
            segments.append(
                SmoothSegment("pivot", support, number, state.time, end, first, coefficients, place)
            )
        state = replace(reached, time=end)
        if ending != "time":
            return Pivoted(segments, state, ending)
        size *= 2.0
    raise RuntimeError(f"{ELEMENTS} elements did not finish piece {number}")
