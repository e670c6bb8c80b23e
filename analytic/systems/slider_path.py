"""Prescribed paths of the slider in body axes: r, v and w in pieces, with breakpoints
between them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from plumbob.analytic.parameters import ParameterError, finite, positive
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Arc, CapsulePath, PlanePoint

Kinematics = tuple[Array, Array, Array]


def _turning_times(rate: float, acceleration: float, duration: float) -> Array:
    """Returns three times [s]: the beginning, the time at which the motion turns round, and the
    end. If it does not turn round, the middle one equals another."""
    turn = -rate / acceleration if acceleration else 0.0
    return np.array([0.0, min(max(turn, 0.0), duration), duration])


def _columns(vectors: npt.ArrayLike) -> Array:
    """Returns plane vectors x + iy, shape (n,), as an array of shape (n, 2)."""
    return np.asarray(vectors, dtype=np.complex128).view(np.float64).reshape(-1, 2)


@dataclass(frozen=True)
class StraightPiece:
    """A part of a path from local time 0 to `duration` [s] with constant `acceleration` [m/s^2]
    along a line at angle `direction` [rad] through `origin` [m]. At its start, the slider is at
    `position` [m] from `origin` and has `speed` [m/s]."""

    duration: float
    origin: PlanePoint
    direction: float
    position: float
    speed: float
    acceleration: float

    def kinematics(self, times: Array) -> Kinematics:
        """Returns position r [m], velocity v [m/s] and acceleration w [m/s^2] relative to the body,
        each of shape (n, 2), at local `times` [s], shape (n,) (Chernousko 2020, eqs. 12, 16)."""
        along = complex(math.cos(self.direction), math.sin(self.direction))
        shift = self.position + times * (self.speed + 0.5 * self.acceleration * times)
        return (
            _columns(complex(*self.origin) + shift * along),
            _columns((self.speed + self.acceleration * times) * along),
            _columns(np.full(times.shape, self.acceleration * along)),
        )

    def track(self) -> CapsulePath:
        """Returns the corners of the part of the line that the piece covers."""
        times = _turning_times(self.speed, self.acceleration, self.duration)
        corners, _, _ = self.kinematics(times)
        x, y = corners.T
        return tuple(zip(x.tolist(), y.tolist(), strict=True))


@dataclass(frozen=True)
class ArcPiece:
    """A part of a path with constant angular `acceleration` [rad/s^2] on the circle of `radius` [m]
    about C. At its start, the slider is at `angle` [rad] and has the angular velocity `rate`
    [rad/s]."""

    duration: float
    radius: float
    angle: float
    rate: float
    acceleration: float

    def kinematics(self, times: Array) -> Kinematics:
        """Returns position r [m], velocity v [m/s] and acceleration w [m/s^2] relative to the body,
        each of shape (n, 2), at local `times` [s], shape (n,) (Chernousko 2020, eqs. 26-27)."""
        rate = self.rate + self.acceleration * times
        outward = self.radius * np.exp(1j * self._angles(times))
        return (
            _columns(outward),
            _columns(1j * rate * outward),
            _columns((1j * self.acceleration - rate**2) * outward),
        )

    def track(self) -> CapsulePath:
        """Returns the arc that the piece covers."""
        angles = self._angles(_turning_times(self.rate, self.acceleration, self.duration))
        return (Arc(self.radius, float(angles.min()), float(angles.max())),)

    def _angles(self, times: Array) -> Array:
        """Returns the angle [rad] at local `times` [s], shape (n,)."""
        return self.angle + times * (self.rate + 0.5 * self.acceleration * times)


Piece = StraightPiece | ArcPiece


@dataclass(frozen=True)
class SliderPath:
    """Pieces in order. Each begins with the position and velocity at the end of the one before. The
    path ends with the slider at rest, and the slider stays there. Raises ParameterError."""

    pieces: tuple[Piece, ...]

    def __post_init__(self) -> None:
        if not self.pieces:
            raise ParameterError("path", self.pieces, "at least one piece")
        for piece in self.pieces:
            r, v, _ = piece.kinematics(np.array([0.0, piece.duration]))
            if not (piece.duration >= 0.0 and np.isfinite(r).all() and np.isfinite(v).all()):
                raise ParameterError("path", piece, "finite, with a duration of 0 or more")

    @cached_property
    def breakpoints(self) -> Array:
        """Start of each piece and end of the last one [s], shape (pieces + 1,)."""
        return np.array([0.0, *itertools.accumulate(piece.duration for piece in self.pieces)])

    @property
    def duration(self) -> float:
        """Time from which the slider rests in the body [s]."""
        return float(self.breakpoints[-1])

    @property
    def end(self) -> PlanePoint:
        """The place where the slider stops, relative to C [m]."""
        last = self.pieces[-1]
        places, _, _ = last.kinematics(np.array([last.duration]))
        x, y = places[0]
        return float(x), float(y)

    def kinematics(self, times: Array) -> Kinematics:
        """Returns position [m], velocity [m/s] and acceleration [m/s^2] relative to the body, each
        of shape (n, 2), at `times` [s], shape (n,). A breakpoint belongs to the piece that begins
        there."""
        times = np.asarray(times, dtype=np.float64)
        numbers = np.searchsorted(self.breakpoints, times, side="right") - 1
        result = tuple(np.zeros((times.size, 2)) for _ in range(3))
        result[0][:] = self.end
        for number in np.unique(numbers[numbers < len(self.pieces)]):
            selected = numbers == number
            local = times[selected] - self.breakpoints[number]
            parts = self.pieces[number].kinematics(local)
            for values, part in zip(result, parts, strict=True):
                values[selected] = part
        return result[0], result[1], result[2]

    def places(self, times: Array) -> Array:
        """Returns the position relative to C [m], shape (n, 2), at `times` [s], shape (n,)."""
        return self.kinematics(times)[0]

    def velocities(self, times: Array) -> Array:
        """Returns the velocity in the body [m/s], shape (n, 2), at `times` [s], shape (n,)."""
        return self.kinematics(times)[1]

    def track(self) -> CapsulePath:
        """Returns the corners and arcs that the slider covers, for `capsule.validity`."""
        return tuple(itertools.chain.from_iterable(piece.track() for piece in self.pieces))


def concatenate(*paths: SliderPath) -> SliderPath:
    """Returns the path that follows `paths` in order. Each begins where the one before ends."""
    return SliderPath(tuple(itertools.chain.from_iterable(path.pieces for path in paths)))


def fixed(place: PlanePoint, duration: float = 0.0) -> SliderPath:
    """Returns the path of a slider fixed at `place` relative to C [m] for `duration` [s] (and
    afterwards)."""
    piece = StraightPiece(
        duration=duration,
        origin=place,
        direction=0.0,
        position=0.0,
        speed=0.0,
        acceleration=0.0,
    )
    return SliderPath((piece,))


def _path_from_rest(
    piece: Callable[..., Piece],
    place: float,
    accelerations: Sequence[float],
    durations: Sequence[float],
) -> SliderPath:
    """Returns a path from rest at `place` with constant `accelerations`, one for each of
    `durations` [s]. `piece` makes a piece from its duration, place, rate and acceleration."""
    pieces = []
    rate = 0.0
    for w, t in zip(accelerations, durations, strict=True):
        pieces.append(piece(positive("duration", t), place, rate, w))
        place = place + t * (rate + 0.5 * w * t)
        rate = rate + w * t
    return SliderPath(tuple(pieces))


def straight(
    start: PlanePoint,
    direction: float,
    accelerations: Sequence[float],
    durations: Sequence[float],
) -> SliderPath:
    """Returns a path from rest at `start` [m] along `direction` [rad] with constant `accelerations`
    [m/s^2], one for each of `durations` [s]. Raises ParameterError."""

    def piece(duration: float, position: float, speed: float, acceleration: float) -> Piece:
        """Returns a straight piece on the line."""
        return StraightPiece(duration, start, direction, position, speed, acceleration)

    return _path_from_rest(piece, 0.0, accelerations, durations)


def arc(
    radius: float, start: float, accelerations: Sequence[float], durations: Sequence[float]
) -> SliderPath:
    """Returns a path from rest at angle `start` [rad] on the circle of `radius` [m] about C with
    constant angular `accelerations` [rad/s^2], one for each of `durations` [s]. Raises
    ParameterError."""
    positive("radius", radius)
    first_angle = finite("start", start)

    def piece(duration: float, angle: float, rate: float, acceleration: float) -> Piece:
        """Returns a piece on the circle."""
        return ArcPiece(duration, radius, angle, rate, acceleration)

    return _path_from_rest(piece, first_angle, accelerations, durations)


def line_stroke(
    start: PlanePoint, direction: float, w1: float, w2: float, t1: float
) -> SliderPath:
    """Returns the path with acceleration w1 [m/s^2] for t1 [s], then -w2 until the slider stops
    (Chernousko 2020, eqs. 14, 17). Raises ParameterError."""
    positive("w1", w1)
    positive("w2", w2)
    positive("t1", t1)
    return straight(start, direction, (w1, -w2), (t1, w1 * t1 / w2))


def arc_stroke(
    radius: float, start: float, angular_acceleration: float, half_time: float
) -> SliderPath:
    """Returns the path with angular acceleration Z [rad/s^2], of either sign, for tau = `half_time`
    [s], then -Z for tau (Chernousko 2020, eq. 29). Raises ParameterError."""
    positive("half_time", half_time)
    z = finite("angular_acceleration", angular_acceleration)
    return arc(radius, start, (z, -z), (half_time, half_time))
