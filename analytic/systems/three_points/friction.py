"""Exact motion of a body on three Coulomb points with a prescribed slider, event after event.

Modes: all supports slide; one rests and the body pivots about it; all rest (two at rest are all at
rest). Each is followed smoothly to its event, and the next one is decided by Gauss' principle.
Chernousko 2020, eqs. 1-4; the mode changes are this project's own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.parameters import ParameterError, finite
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule, validity
from plumbob.analytic.systems.slider_path import Piece, SliderPath, StraightPiece
from plumbob.analytic.systems.three_points.collocation import scheme
from plumbob.analytic.systems.three_points.element import STUCK, Accuracy
from plumbob.analytic.systems.three_points.equations import Mechanics, configuration, mechanics
from plumbob.analytic.systems.three_points.events import (
    Now,
    begin,
    leave_later,
    stopped,
    with_one_at_rest,
)
from plumbob.analytic.systems.three_points.holding import held_until
from plumbob.analytic.systems.three_points.motion import Event, ThreePointMotion
from plumbob.analytic.systems.three_points.pivoting import pivot
from plumbob.analytic.systems.three_points.sliding import slide
from plumbob.analytic.systems.three_points.smooth_segment import (
    SmoothSegment,
    State,
    at_rest,
    com_of,
)

EVENTS = 500  # in one piece, before giving up
COARSER, COARSER_NODES = 100.0, 6  # the motion that shows the error has a larger one by far


@dataclass(frozen=True)
class Start:
    """Pose and velocity of the body at time 0 on the ground: place of C [m], heading [rad],
    velocity of C [m/s], angular velocity [rad/s]."""

    position: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0
    velocity: tuple[float, float] = (0.0, 0.0)
    angular_velocity: float = 0.0


def _piece_motion(
    body: Mechanics, piece: Piece, number: int, duration: float, now: Now, accuracy: Accuracy
) -> tuple[list[SmoothSegment], Now]:
    """All segments of one piece, and the mode at its end."""
    segments: list[SmoothSegment] = []
    for _ in range(EVENTS):
        state = now.state
        if now.mode == "rest":
            broken = held_until(body, piece, state.time, duration, state.heading)
            end = duration if broken is None else broken
            if end > state.time:
                segments.append(SmoothSegment("rest", -1, number, state.time, end, state))
            com = com_of(body, configuration(body, piece, np.array([state.time])), state)
            if not np.isfinite(end):
                return segments, now
            state = at_rest(body, piece, end, state.heading, com)
            now = Now(state, "rest")
            if broken is None:
                return segments, now
            now = leave_later(body, piece, state, None, duration)
        elif now.mode == "pivot":
            turned = pivot(body, piece, number, duration, state, now.support, now.sense, accuracy)
            segments += turned.segments
            if turned.ending == "time":
                return segments, Now(turned.state, "pivot", now.support, now.sense)
            if turned.ending == "slip":
                now = leave_later(body, piece, turned.state, now.support, duration)
            else:
                now = stopped(body, piece, turned.state)
        else:
            slid = slide(
                *(body, piece, number, duration, state, accuracy, now.departure, now.support)
            )
            segments += slid.segments
            if not slid.still:
                return segments, Now(slid.state, "slide")
            now = (
                with_one_at_rest(body, piece, slid.state, slid.still[0], 0.0)
                if len(slid.still) == 1
                else stopped(body, piece, slid.state)
            )
    raise RuntimeError(f"{EVENTS} events did not finish piece {number}")


def _initial(body: Mechanics, piece: Piece, start: Start) -> Now:
    at = configuration(body, piece, np.zeros(1))
    turn = np.exp(1j * start.heading)
    com, omega = complex(*start.position), start.angular_velocity
    if not any(start.velocity) and omega == 0.0:
        return Now(at_rest(body, piece, 0.0, start.heading, com), "rest")
    place = com + body.mass_ratio * complex(at.position[0]) * turn
    own = complex(*start.velocity) / turn
    point = own + 1j * omega * body.mass_ratio * complex(at.position[0])
    state = State(0.0, complex(point), omega, start.heading, complex(place))
    speeds = np.abs(own + 1j * omega * body.supports)
    still = np.flatnonzero(speeds <= STUCK * speeds.max())
    return Now(state, "pivot", int(still[0])) if still.size else Now(state, "slide")


def _integrate(
    body: Mechanics, path: SliderPath, start: Start, until: float, accuracy: Accuracy
) -> tuple[SmoothSegment, ...]:
    pieces = (*path.pieces, StraightPiece(np.inf, path.end, 0.0, 0.0, 0.0, 0.0))
    now, segments = _initial(body, pieces[0], start), list[SmoothSegment]()
    for number, piece in enumerate(pieces):
        began = float(path.breakpoints[number])
        duration = min(piece.duration, until - began)
        if duration <= 0.0 and number < len(path.pieces):
            continue
        now = begin(body, piece, now)
        found, now = _piece_motion(body, piece, number, duration, now, accuracy)
        segments += found
        if until <= began + piece.duration:
            break
        now = replace(now, state=replace(now.state, time=0.0), departure=None)
    return tuple(segments)


def _events(segments: tuple[SmoothSegment, ...], breakpoints: Array) -> tuple[Event, ...]:
    events: list[Event] = []
    for segment in segments:
        continued = bool(events) and segment.mode == events[-1].mode
        slips = segment.mode == "slide" and segment.support >= 0
        if not continued or slips:
            time = float(breakpoints[segment.piece]) + segment.start
            events.append(Event(time, segment.mode, segment.support))
    return tuple(events)


def three_point_motion(
    capsule: Capsule,
    path: SliderPath,
    start: Start | None = None,
    *,
    tilt: tuple[float, float] = (0.0, 0.0),
    until: float = np.inf,
    nodes: int = 24,
    tolerance: float = 1e-11,
) -> ThreePointMotion:
    """Motion of `capsule` from `start` (None: rest at the origin) while the slider follows `path`,
    until the body rests for good or `until` [s].

    `tilt` is the in-plane part of gravity along ground axes [m/s^2], at unchanged normal forces;
    `nodes` and `tolerance` set the discretisation (`three_points.collocation`). Raises
    ParameterError where a support would lose contact, or if nothing would ever stop the body.
    """
    start = Start() if start is None else start
    for name, value in (("x", start.position[0]), ("y", start.position[1])):
        finite(name, value)
    finite("heading", start.heading), finite("angular_velocity", start.angular_velocity)
    for error in validity(capsule, path.track()):
        raise error
    if capsule.friction == 0.0 and not np.isfinite(until):
        raise ParameterError("friction", 0.0, "greater than 0 for a motion without `until`")
    body = mechanics(capsule, tilt)
    segments = _integrate(body, path, start, until, Accuracy(scheme(nodes), tolerance))

    def coarser() -> ThreePointMotion:
        return three_point_motion(
            capsule,
            path,
            start,
            tilt=tilt,
            until=until,
            nodes=nodes - COARSER_NODES,
            tolerance=COARSER * tolerance,
        )

    events = _events(segments, path.breakpoints)
    return ThreePointMotion(capsule, path, body, segments, events, coarser)
