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
    ZERO_SLIP,
    Slip,
    onset_acceleration,
    slip_acceleration,
)
from plumbob.analytic.systems.three_points.motion import Segments, ThreePointMotion
from plumbob.analytic.systems.three_points.pivoting import Pivot, integrate_pivot
from plumbob.analytic.systems.three_points.rest import (
    LIMIT_ROUNDING,
    held_until,
    needed_wrench,
)
from plumbob.analytic.systems.three_points.sliding import (
    Guess,
    integrate_slide,
    resting_supports,
)
from plumbob.analytic.systems.three_points.smooth_segment import (
    Accuracy,
    Interval,
    Mode,
    SegmentState,
    SmoothSegment,
    rest_segment,
)

MAX_EVENTS = 500  # largest number of events in one piece of the path
# The difference from a second, less accurate motion gives the error: the factor on the tolerance of
# that motion, and the number of nodes by which it has fewer.
COARSER_TOLERANCE, COARSER_NODES = 100.0, 6
# First delay after which a slip that grows from zero is examined, as a fraction of the horizon
FIRST_DELAY = 1e-6


@dataclass(frozen=True)
class InitialVelocities:
    """Initial velocity of C [m/s] and angular velocity [rad/s]; at time 0 C is the origin and the
    heading is 0."""

    velocity: tuple[float, float] = (0.0, 0.0)
    angular_velocity: float = 0.0


@dataclass(frozen=True)
class ModeStart:
    """The state at which a mode begins, and the mode. `support` is the support at rest in a pivot,
    or the support that slips first in a slide, else -1. `sense` is the sign of a pivot's turning.
    `departure` gives first guesses for a slide that begins with a support at rest."""

    state: SegmentState
    mode: Mode
    support: int = -1
    sense: float = 1.0
    departure: Guess | None = None


@lru_cache(maxsize=16)  # the reference and the theory of errors ask for the same motion
def three_point_motion(
    capsule: Capsule,
    path: SliderPath,
    start: InitialVelocities = InitialVelocities(),
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
        tolerance=COARSER_TOLERANCE * tolerance,
    )
    integrate = partial(_integrate_path, body, path, start, accuracy)
    return ThreePointMotion(capsule, path, body, integrate, coarser)


def _integrate_piece(interval: Interval, begin: ModeStart) -> ModeResult:
    """Returns all segments of one piece of the path, and the mode at its end."""
    phases = {"rest": _rest_phase, "pivot": _pivot_phase, "slide": _slide_phase}
    segments = list[SmoothSegment]()
    for _ in range(MAX_EVENTS):
        phase_segments, begin = phases[begin.mode](interval, begin)
        segments += phase_segments
        if not begin.state.time < interval.piece.duration:
            return segments, begin
    raise RuntimeError(f"{MAX_EVENTS} events did not finish piece {interval.number}")


ModeResult = tuple[list[SmoothSegment], ModeStart]
"""The segments of one mode, and the mode that follows. At the end of a piece the mode stays."""


def _rest_phase(interval: Interval, begin: ModeStart) -> ModeResult:
    """Returns the rest that starts at `begin`, and the mode that follows when static friction no
    longer suffices."""
    duration = interval.piece.duration
    slip_time = held_until(interval.body, interval.piece, begin.state.time)
    end = duration if slip_time is None else slip_time
    segments = [rest_segment(interval, end, begin.state)] if end > begin.state.time else []
    state = replace(begin.state, time=end)
    if slip_time is None:
        return segments, ModeStart(state, "rest")
    horizon = duration - end
    following = _mode_beyond_limit(partial(_mode_from_rest, interval, state), "rest", horizon)
    if following.mode == "rest":  # the load only touched the friction limit
        following = ModeStart(replace(state, time=end + FIRST_DELAY * horizon), "rest")
    return segments, following


def _pivot_phase(interval: Interval, begin: ModeStart) -> ModeResult:
    """Returns the pivot that starts at `begin`, and the mode that follows when the turning stops or
    the support slips."""
    pivot = Pivot(interval, begin.support, begin.sense)
    segments, state, ending = integrate_pivot(pivot, begin.state)
    if ending == "time":
        return segments, replace(begin, state=state)
    if ending == "stop":
        return segments, _mode_after_stop(interval, state)
    rate = float(pivot.motion(interval.at(state.time), np.array([state.omega]))[0][0])
    horizon = min(interval.piece.duration - state.time, abs(state.omega / rate))
    mode_after = partial(_mode_with_support_at_rest, interval, state, begin.support)
    return segments, _mode_beyond_limit(mode_after, "pivot", horizon)


def _slide_phase(interval: Interval, begin: ModeStart) -> ModeResult:
    """Returns the slide that starts at `begin`, and the mode that follows when a support, or the
    whole body, comes to rest."""
    segments, state, resting = integrate_slide(
        interval, begin.state, begin.departure, begin.support
    )
    if not resting:
        return segments, ModeStart(state, "slide")
    if len(resting) == 1:
        return segments, _mode_with_support_at_rest(interval, state, resting[0], 0.0)
    return segments, _mode_after_stop(interval, state)


def _first_mode(interval: Interval, start: InitialVelocities) -> ModeStart:
    """Returns the mode with which the motion begins at time 0."""
    omega = start.angular_velocity
    mu = interval.body.mass_ratio
    slider = complex(interval.at(0.0).position[0])
    # velocity of the common centre of mass
    velocity = complex(*start.velocity) + 1j * omega * mu * slider
    state = SegmentState(0.0, complex(velocity), omega, 0.0, 0j)
    resting = resting_supports(interval.at(0.0), state, 0.0)
    if len(resting) == 1:
        return ModeStart(state, "pivot", *resting)
    return ModeStart(state, "rest" if resting else "slide")


def _integrate_path(
    body: Mechanics, path: SliderPath, start: InitialVelocities, accuracy: Accuracy
) -> Segments:
    """Returns the segments of the whole motion: along every piece of the path, then with the slider
    fixed at the path's end until the body rests."""
    fixed_piece = StraightPiece(
        duration=np.inf,
        origin=path.end,
        direction=0.0,
        position=0.0,
        speed=0.0,
        acceleration=0.0,
    )
    begin = None
    segments = list[SmoothSegment]()
    for number, piece in enumerate((*path.pieces, fixed_piece)):
        interval = Interval(body, piece, number, accuracy)
        begin = _mode_at_piece_start(interval, begin or _first_mode(interval, start))
        piece_segments, begin = _integrate_piece(interval, begin)
        segments += piece_segments
        begin = replace(begin, state=replace(begin.state, time=0.0), departure=None)
    return tuple(segments)


def _departure_guess(
    slip: Slip, delay: float, support: int = 0, omega: float = 0.0, rate: float = 0.0
) -> Guess:
    """Returns a function from times to first guesses of the velocity p of C and the angular
    velocity omega, (p_x, p_y, omega), of a slide that begins with the accelerations `slip`. The
    body comes from rest, or from a pivot about `support` with angular velocity `omega` [rad/s] and
    angular acceleration `rate` [rad/s^2]. If `delay` > 0 [s], the accelerations rise linearly from
    0 and reach `slip` at the time `delay`."""

    def guess(times: Array, terms: Configuration) -> Array:
        """Returns (p_x, p_y, omega) at `times` [s] after the start, shape (n, 3)."""
        effective_times = times**2 / (2.0 * delay) if delay else times
        turning = omega + rate * times
        velocity = slip[0] * effective_times - 1j * turning * terms.arms[:, support]
        angular_velocity = turning + slip[1] * effective_times
        return np.column_stack([velocity.real, velocity.imag, angular_velocity])

    return guess


def _mode_from_rest(interval: Interval, state: SegmentState, delay: float) -> ModeStart:
    """Returns the mode of a body at rest in `state`, from the wrench that acts `delay` [s] later.
    `delay` is > 0 if the wrench has just reached the friction limit: the present wrench then moves
    nothing."""
    terms = interval.at(state.time + delay)
    (force,), (torque,) = needed_wrench(interval.body, terms)
    slip = onset_acceleration(interval.body.mass, terms, complex(force), float(torque))
    if slip == ZERO_SLIP:
        return ModeStart(state, "rest")
    support_accelerations = slip[0] + 1j * slip[1] * terms.arms[0]
    resting = np.flatnonzero(support_accelerations == 0.0)
    if resting.size:
        return ModeStart(state, "pivot", int(resting[0]), float(np.sign(slip[1])))
    return ModeStart(state, "slide", departure=_departure_guess(slip, delay))


def _mode_with_support_at_rest(
    interval: Interval, state: SegmentState, support: int, delay: float
) -> ModeStart:
    """Returns the mode with `support` at rest while the others slide: a pivot if the support
    sticks, else a slide. The forces are those `delay` [s] later, as in `_mode_from_rest`."""
    terms = interval.at(state.time)
    sense = float(np.sign(state.omega))
    pivot = Pivot(interval, support, sense)
    (rate,), (needed,) = pivot.motion(terms, np.array([state.omega]))
    if delay:
        terms = interval.at(state.time + delay)
        _, (needed,) = pivot.motion(terms, np.array([state.omega + delay * rate]))
    limit = float(terms.limits[0, support])
    if abs(needed) <= limit * (1.0 + LIMIT_ROUNDING):
        return ModeStart(state, "pivot", support, sense)
    slip = slip_acceleration(interval.body.mass, terms, support, complex(needed))
    guess = _departure_guess((slip, 0.0), delay, support, state.omega, rate)
    return ModeStart(state, "slide", support, departure=guess)


def _mode_beyond_limit(
    mode_after: Callable[[float], ModeStart], present: Mode, horizon: float
) -> ModeStart:
    """Returns the mode that begins where a load has just reached the friction limit and keeps
    growing. `mode_after` gives the mode from the forces after a delay [s]. The delay grows, within
    `horizon` [s], until that mode is not the `present` one."""
    delay = FIRST_DELAY * horizon
    begin = mode_after(delay)
    while begin.mode == present and 4.0 * delay <= horizon:
        delay *= 4.0
        begin = mode_after(delay)
    return begin


def _mode_after_stop(interval: Interval, state: SegmentState) -> ModeStart:
    """Returns the mode that follows when the body has come to rest."""
    return _mode_from_rest(interval, replace(state, velocity=0j, omega=0.0), 0.0)


def _mode_at_piece_start(interval: Interval, begin: ModeStart) -> ModeStart:
    """Returns the mode at the start of a piece of the path, where the slider's acceleration may
    have jumped."""
    if begin.mode == "rest":
        return _mode_after_stop(interval, begin.state)
    if begin.mode == "pivot":
        return _mode_with_support_at_rest(interval, begin.state, begin.support, 0.0)
    return begin
