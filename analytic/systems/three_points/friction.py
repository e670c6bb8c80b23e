"""Exact motion of a body on three Coulomb points with a prescribed slider, event after event.

Modes: all supports slide; one rests and the body pivots about it; all rest (two at rest are all at
rest). Each is integrated smoothly to its event, and the next mode is decided by Gauss' principle.
Chernousko 2020, eqs. 1-4; the mode changes are this project's own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from plumbob.analytic.numerics.collocation import radau_collocation
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule, check_loads
from plumbob.analytic.systems.slider_path import SliderPath, StraightPiece
from plumbob.analytic.systems.three_points.equations import (
    Configuration,
    Mechanics,
    mechanics,
)
from plumbob.analytic.systems.three_points.implicit_friction import (
    REST,
    Slip,
    onset,
    slip_onset,
)
from plumbob.analytic.systems.three_points.motion import Segments, ThreePointMotion
from plumbob.analytic.systems.three_points.pivoting import Pivot, pivot
from plumbob.analytic.systems.three_points.rest import (
    EDGE,
    held_until,
    needed_wrench,
)
from plumbob.analytic.systems.three_points.sliding import Guess, at_rest, slide
from plumbob.analytic.systems.three_points.smooth_segment import (
    Accuracy,
    Interval,
    Mode,
    SmoothSegment,
    State,
    resting,
)

EVENTS = 500  # in one piece, before giving up
# a motion less accurate by far, whose difference is the error
COARSER, COARSER_NODES = 100.0, 6
LATER = 1e-6  # of what is left of a piece: where a start that grows from nothing is examined


@dataclass(frozen=True)
class Start:
    """Velocity of C [m/s] and angular velocity [rad/s] at time 0, with C at the origin and heading
    0."""

    velocity: tuple[float, float] = (0.0, 0.0)
    angular_velocity: float = 0.0


@dataclass(frozen=True)
class Now:
    """A mode about to begin."""

    state: State
    mode: Mode
    support: int = -1
    sense: float = 1.0
    departure: Guess | None = None


@lru_cache(maxsize=16)  # a reference and what theory samples are one motion
def three_point_motion(
    capsule: Capsule,
    path: SliderPath,
    start: Start = Start(),
    *,
    nodes: int = 24,
    tolerance: float = 1e-11,
) -> ThreePointMotion:
    """Motion of `capsule` from `start` while the slider follows `path`,
    until its final rest.

    `nodes` and `tolerance` set the discretisation (see `radau_collocation`). Raises
    ParameterError where a support would lose contact, or if the body would never stop.
    """
    check_loads(capsule, path.track())
    if capsule.friction == 0.0:
        raise ParameterError("friction", 0.0, "greater than 0 for the body to stop")
    body = mechanics(capsule)
    accuracy = Accuracy(radau_collocation(nodes), tolerance)

    coarser = partial(
        three_point_motion,
        *(capsule, path, start),
        nodes=nodes - COARSER_NODES,
        tolerance=COARSER * tolerance,
    )
    integrated = partial(_integrate, body, path, start, accuracy)
    return ThreePointMotion(capsule, path, body, integrated, coarser)


def _piece_motion(interval: Interval, now: Now) -> Phase:
    """All segments of one piece, and the mode at its end."""
    segments = list[SmoothSegment]()
    for _ in range(EVENTS):
        phase = {"rest": _resting, "pivot": _pivoting, "slide": _sliding}[now.mode]
        phase_segments, now = phase(interval, now)
        segments += phase_segments
        if not now.state.time < interval.piece.duration:
            return segments, now
    raise RuntimeError(f"{EVENTS} events did not finish piece {interval.number}")


Phase = tuple[list[SmoothSegment], Now]
"""Segments of one mode, and the mode after it, at the end of the piece the same one."""


def _resting(interval: Interval, now: Now) -> Phase:
    """Rest until static friction no longer suffices."""
    duration = interval.piece.duration
    broken = held_until(interval.body, interval.piece, now.state.time)
    end = duration if broken is None else broken
    segments = [resting(interval, end, now.state)] if end > now.state.time else []
    state = replace(now.state, time=end)
    horizon = duration - end
    if broken is None:
        return segments, Now(state, "rest")
    later = _leave_later(partial(_from_rest, interval, state), "rest", horizon)
    if later.mode == "rest":  # the load only touched the limit
        later = Now(replace(state, time=end + LATER * horizon), "rest")
    return segments, later


def _pivoting(interval: Interval, now: Now) -> Phase:
    """Pivot until the turning stops or the support slips."""
    turning = Pivot(interval, now.support, now.sense)
    segments, state, ending = pivot(turning, now.state)
    if ending == "time":
        return segments, replace(now, state=state)
    if ending == "slip":
        rate = turning.motion(interval.at(state.time), np.array([state.omega]))[0]
        horizon = min(interval.piece.duration - state.time, abs(state.omega / float(rate[0])))
        following = partial(_with_one_at_rest, interval, state, now.support)
        return segments, _leave_later(following, "pivot", horizon)
    return segments, _stopped(interval, state)


def _sliding(interval: Interval, now: Now) -> Phase:
    """Slide until a support, or the whole body, comes to rest."""
    segments, state, still = slide(interval, now.state, now.departure, now.support)
    if not still:
        return segments, Now(state, "slide")
    if len(still) == 1:
        return segments, _with_one_at_rest(interval, state, still[0], 0.0)
    return segments, _stopped(interval, state)


def _initial(interval: Interval, start: Start) -> Now:
    omega = start.angular_velocity
    velocity = complex(*start.velocity)
    mu = interval.body.mass_ratio
    point = velocity + 1j * omega * mu * complex(interval.at(0.0).position[0])
    state = State(0.0, complex(point), omega, 0.0, 0j)
    still = at_rest(interval.at(0.0), state, 0.0)
    if len(still) == 1:
        return Now(state, "pivot", *still)
    return Now(state, "rest" if still else "slide")


def _integrate(body: Mechanics, path: SliderPath, start: Start, accuracy: Accuracy) -> Segments:
    pieces = (*path.pieces, StraightPiece(np.inf, path.end, 0.0, 0.0, 0.0, 0.0))
    now = None
    segments = list[SmoothSegment]()
    for number, piece in enumerate(pieces):
        interval = Interval(body, piece, number, accuracy)
        now = _begin(interval, now or _initial(interval, start))
        piece_segments, now = _piece_motion(interval, now)
        segments += piece_segments
        now = replace(now, state=replace(now.state, time=0.0), departure=None)
    return tuple(segments)


def _departure(
    slip: Slip, ramp: float, support: int = 0, omega: float = 0.0, rate: float = 0.0
) -> Guess:
    """First guess of a slide from rest, or of `support` out of a pivot at `omega` [rad/s] that
    grows at a `rate`, with the accelerations `slip`; with `ramp` > 0 [s] they grow in proportion to
    time."""

    def guess(times: Array, at: Configuration) -> Array:
        elapsed = times**2 / (2.0 * ramp) if ramp else times
        turning = omega + rate * times
        point = slip[0] * elapsed - 1j * turning * at.arms[:, support]
        return np.column_stack([point.real, point.imag, turning + slip[1] * elapsed])

    return guess


def _from_rest(interval: Interval, state: State, ramp: float) -> Now:
    """The mode that follows rest now; with `ramp` > 0 the one that much later [s], where the wrench
    has just reached the friction limit."""
    at = interval.at(state.time + ramp)
    (force,), (torque,) = needed_wrench(interval.body, at)
    slip = onset(interval.body.mass, at, complex(force), float(torque))
    if slip == REST:
        return Now(state, "rest")
    still = np.flatnonzero(slip[0] + 1j * slip[1] * at.arms[0] == 0.0)
    if still.size:
        return Now(state, "pivot", int(still[0]), float(np.sign(slip[1])))
    return Now(state, "slide", departure=_departure(slip, ramp))


def _with_one_at_rest(interval: Interval, state: State, support: int, ramp: float) -> Now:
    """The mode with `support` at rest while the others slide, now or `ramp` [s] later: a pivot
    while it sticks, else a slide."""
    at = interval.at(state.time)
    sense = float(np.sign(state.omega))
    turning = Pivot(interval, support, sense)
    (rate,), (needed,) = turning.motion(at, np.array([state.omega]))
    if ramp:
        at = interval.at(state.time + ramp)
        _, (needed,) = turning.motion(at, np.array([state.omega + ramp * rate]))
    if abs(needed) <= float(at.limits[0, support]) * (1.0 + EDGE):
        return Now(state, "pivot", support, sense)
    slip = slip_onset(interval.body.mass, at, support, complex(needed))
    guess = _departure((slip, 0.0), ramp, support, state.omega, rate)
    return Now(state, "slide", support, departure=guess)


def _leave_later(following: Callable[[float], Now], stays: Mode, horizon: float) -> Now:
    """The mode `following` so much later [s] where a load has just reached the friction limit and
    continues to grow, as soon as it is not the one that `stays`, within `horizon` [s]."""
    ramp = LATER * horizon
    while (now := following(ramp)).mode == stays and 4.0 * ramp <= horizon:
        ramp *= 4.0
    return now


def _stopped(interval: Interval, state: State) -> Now:
    """The mode that follows where the body has come to rest."""
    return _from_rest(interval, replace(state, point=0j, omega=0.0), 0.0)


def _begin(interval: Interval, now: Now) -> Now:
    """The mode at the start of a piece, where the slider's acceleration may have jumped."""
    if now.mode == "rest":
        return _stopped(interval, now.state)
    if now.mode == "pivot":
        return _with_one_at_rest(interval, now.state, now.support, 0.0)
    return now
