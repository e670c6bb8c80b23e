"""Exact motion of a body on three Coulomb points with a prescribed slider, from event to event.

There are three modes: all supports slide; one support rests and the body pivots about it; all
supports rest (if two rest, the third rests too). Each mode is integrated smoothly to its event.
Gauss' principle then decides the next mode. The equations are from Chernousko 2020, eqs. 1-4; the
mode changes are derived by this project.
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

EVENTS = 500  # largest number of events in one piece of the path
# A second, much less accurate motion gives the error: the difference between the two motions.
COARSER, COARSER_NODES = 100.0, 6
# first delay after which a slip that grows from zero is examined, over the horizon
LATER = 1e-6


@dataclass(frozen=True)
class Start:
    """Initial velocity of C [m/s] and angular velocity [rad/s]; at time 0 C is the origin and the
    heading is 0."""

    velocity: tuple[float, float] = (0.0, 0.0)
    angular_velocity: float = 0.0


@dataclass(frozen=True)
class Now:
    """The state at which a mode begins, and the mode. `support` is the support at rest in a pivot,
    or the support that slips first in a slide, else -1. `sense` is the sign of a pivot's turning.
    `departure` gives first guesses for a slide that begins with a support at rest."""

    state: State
    mode: Mode
    support: int = -1
    sense: float = 1.0
    departure: Guess | None = None


@lru_cache(maxsize=16)  # the reference and the theory of errors ask for the same motion
def three_point_motion(
    capsule: Capsule,
    path: SliderPath,
    start: Start = Start(),
    *,
    nodes: int = 24,
    tolerance: float = 1e-11,
) -> ThreePointMotion:
    """Returns the motion of `capsule` from `start` to its final rest while the slider follows
    `path`.

    `nodes` and `tolerance` set the discretisation (see `radau_collocation`). Raises ParameterError
    if a support would lose contact, or if the body would never stop.
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
    """Returns all segments of one piece of the path, and the mode at its end."""
    segments = list[SmoothSegment]()
    for _ in range(EVENTS):
        phase = {"rest": _resting, "pivot": _pivoting, "slide": _sliding}[now.mode]
        phase_segments, now = phase(interval, now)
        segments += phase_segments
        if not now.state.time < interval.piece.duration:
            return segments, now
    raise RuntimeError(f"{EVENTS} events did not finish piece {interval.number}")


Phase = tuple[list[SmoothSegment], Now]
"""The segments of one mode, and the mode that follows. At the end of a piece the mode stays."""


def _resting(interval: Interval, now: Now) -> Phase:
    """Returns the rest that begins as `now`, and the mode that follows when static friction no
    longer suffices."""
    duration = interval.piece.duration
    broken = held_until(interval.body, interval.piece, now.state.time)
    end = duration if broken is None else broken
    segments = [resting(interval, end, now.state)] if end > now.state.time else []
    state = replace(now.state, time=end)
    horizon = duration - end
    if broken is None:
        return segments, Now(state, "rest")
    later = _leave_later(partial(_from_rest, interval, state), "rest", horizon)
    if later.mode == "rest":  # the load only touched the friction limit
        later = Now(replace(state, time=end + LATER * horizon), "rest")
    return segments, later


def _pivoting(interval: Interval, now: Now) -> Phase:
    """Returns the pivot that begins as `now`, and the mode that follows when the turning stops or
    the support slips."""
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
    """Returns the slide that begins as `now`, and the mode that follows when a support, or the
    whole body, comes to rest."""
    segments, state, still = slide(interval, now.state, now.departure, now.support)
    if not still:
        return segments, Now(state, "slide")
    if len(still) == 1:
        return segments, _with_one_at_rest(interval, state, still[0], 0.0)
    return segments, _stopped(interval, state)


def _initial(interval: Interval, start: Start) -> Now:
    """Returns the mode with which the motion begins at time 0."""
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
    """Returns the segments of the whole motion: along every piece of the path, then with the slider
    fixed at the path's end until the body rests."""
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
    """Returns first guesses of (p_x, p_y, omega) for a slide that begins with the accelerations
    `slip`, from rest or out of a pivot about `support` with angular velocity `omega` [rad/s] and
    its `rate` [rad/s^2]. If `ramp` > 0 [s], the accelerations are those at time `ramp` and grow in
    proportion to time from 0."""

    def guess(times: Array, at: Configuration) -> Array:
        elapsed = times**2 / (2.0 * ramp) if ramp else times
        turning = omega + rate * times
        point = slip[0] * elapsed - 1j * turning * at.arms[:, support]
        return np.column_stack([point.real, point.imag, turning + slip[1] * elapsed])

    return guess


def _from_rest(interval: Interval, state: State, ramp: float) -> Now:
    """Returns the mode of a body at rest in `state`, from the wrench that acts `ramp` [s] later.
    `ramp` is > 0 if the wrench has just reached the friction limit: the present wrench then moves
    nothing."""
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
    """Returns the mode with `support` at rest while the others slide: a pivot if the support
    sticks, else a slide. The forces are those `ramp` [s] later, as in `_from_rest`."""
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
    """Returns the mode that begins where a load has just reached the friction limit and keeps
    growing. `following` gives the mode from the forces after a delay [s]. The delay grows, within
    `horizon` [s], until that mode is not `stays`."""
    ramp = LATER * horizon
    while (now := following(ramp)).mode == stays and 4.0 * ramp <= horizon:
        ramp *= 4.0
    return now


def _stopped(interval: Interval, state: State) -> Now:
    """Returns the mode that follows when the body has come to rest."""
    return _from_rest(interval, replace(state, point=0j, omega=0.0), 0.0)


def _begin(interval: Interval, now: Now) -> Now:
    """Returns the mode at the start of a piece of the path, where the slider's acceleration may
    have jumped."""
    if now.mode == "rest":
        return _stopped(interval, now.state)
    if now.mode == "pivot":
        return _with_one_at_rest(interval, now.state, now.support, 0.0)
    return now
