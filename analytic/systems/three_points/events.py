"""What a body on three Coulomb points does next: stay, pivot or slide, and in which direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.slider_path import Piece
from plumbob.analytic.systems.three_points.element import Guess
from plumbob.analytic.systems.three_points.equations import Configuration, Mechanics, configuration
from plumbob.analytic.systems.three_points.pivoting import pivot_motion
from plumbob.analytic.systems.three_points.rest import EDGE, Onset, needed_wrench, onset, slip_onset
from plumbob.analytic.systems.three_points.smooth_segment import Mode, State, at_rest, com_of

LATER = 1e-6  # of what is left of a piece: where a start that grows from nothing is looked at


@dataclass(frozen=True)
class Now:
    """A mode about to begin."""

    state: State
    mode: Mode
    support: int = -1
    sense: float = 1.0
    departure: Guess | None = None


def _slide_from_rest(answer: Onset, ramp: float) -> Guess:
    def guess(times: Array, at: Configuration) -> Array:
        elapsed = times**2 / (2.0 * ramp) if ramp else times
        point, omega = answer.linear * elapsed, answer.angular * elapsed
        return np.column_stack([point.real, point.imag, omega])

    return guess


def _slide_from_pivot(support: int, slip: complex, omega: float, rate: float, ramp: float) -> Guess:
    def guess(times: Array, at: Configuration) -> Array:
        elapsed = times**2 / (2.0 * ramp) if ramp else times
        turning = omega + rate * times
        point = slip * elapsed - 1j * turning * at.arms[:, support]
        return np.column_stack([point.real, point.imag, turning])

    return guess


def from_rest(body: Mechanics, piece: Piece, state: State, ramp: float) -> Now:
    """What a body at rest does now; with `ramp` > 0, what it does that much later [s], its needed
    wrench having just reached the edge of what friction can give."""
    at = configuration(body, piece, np.array([state.time + ramp]))
    force, torque = needed_wrench(body, at, state.heading)
    answer = onset(
        *(body.mass, float(at.inertia[0]), at.limits[0], at.arms[0]),
        *(complex(force[0]), float(torque[0])),
    )
    if answer.mode == "pivot":
        return Now(state, "pivot", answer.support, float(np.sign(answer.angular)))
    if answer.mode == "slide":
        return Now(state, "slide", departure=_slide_from_rest(answer, ramp))
    return Now(state, "rest")


def with_one_at_rest(body: Mechanics, piece: Piece, state: State, support: int, ramp: float) -> Now:
    """Whether the support at rest stays while the others slide, now or `ramp` [s] later."""
    at = configuration(body, piece, np.array([state.time]))
    omega, sense = np.array([state.omega]), float(np.sign(state.omega))
    motion = pivot_motion(body, at, support, sense, omega, np.array([state.heading]))
    rate = float(motion.omega_rate[0])
    if ramp:
        at = configuration(body, piece, np.array([state.time + ramp]))
        heading = np.array([state.heading + ramp * state.omega])
        motion = pivot_motion(body, at, support, sense, omega + ramp * rate, heading)
    share, limit = complex(motion.share[0]), float(at.limits[0, support])
    if abs(share) <= limit * (1.0 + EDGE):
        return Now(state, "pivot", support, sense)
    slip = slip_onset(body.mass, float(at.inertia[0]), limit, complex(at.arms[0, support]), share)
    guess = _slide_from_pivot(support, slip, state.omega, rate, ramp)
    return Now(state, "slide", support, departure=guess)


def _time_to_stop(body: Mechanics, piece: Piece, state: State, support: int) -> float:
    at = configuration(body, piece, np.array([state.time]))
    omega, sense = np.array([state.omega]), float(np.sign(state.omega))
    motion = pivot_motion(body, at, support, sense, omega, np.array([state.heading]))
    return abs(state.omega / float(motion.omega_rate[0]))


def leave_later(
    body: Mechanics, piece: Piece, state: State, support: int | None, duration: float
) -> Now:
    """The mode that follows a hold that has just reached its limit and goes on growing."""
    horizon = duration - state.time
    if support is not None:
        horizon = min(horizon, _time_to_stop(body, piece, state, support))
    ramp = LATER * horizon
    while ramp <= horizon:
        now = (
            from_rest(body, piece, state, ramp)
            if support is None
            else with_one_at_rest(body, piece, state, support, ramp)
        )
        if now.mode != ("rest" if support is None else "pivot"):
            return now
        ramp *= 4.0
    if support is not None:
        return now
    # The load only touched the limit: the hold goes on from a little later.
    com = com_of(body, configuration(body, piece, np.array([state.time])), state)
    later = state.time + LATER * horizon
    return Now(at_rest(body, piece, later, state.heading, com), "rest")


def stopped(body: Mechanics, piece: Piece, state: State) -> Now:
    com = com_of(body, configuration(body, piece, np.array([state.time])), state)
    return from_rest(body, piece, at_rest(body, piece, state.time, state.heading, com), 0.0)


def begin(body: Mechanics, piece: Piece, now: Now) -> Now:
    """The mode at the start of a piece, where the slider's acceleration may have jumped."""
    if now.mode == "rest":
        return stopped(body, piece, now.state)
    if now.mode == "pivot":
        return with_one_at_rest(body, piece, now.state, now.support, 0.0)
    return now
