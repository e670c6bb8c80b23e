"""The manoeuvres of a plan as data: kind, parameters and the slider's path."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.slider_path import (
    SliderPath,
    arc,
    arc_stroke,
    fixed,
    line_stroke,
    straight,
)
from plumbob.analytic.systems.three_points.equations import mechanics
from plumbob.analytic.systems.three_points.rest import excess_load, holding_limit

ManoeuvreKind = Literal["slow", "turn", "line", "wait"]

ANYWHERE, FIRST_SEGMENT, ARC, SECOND_SEGMENT = range(4)  # parts of a track
# [m] or [rad] largest distance of two places of the slider that count as one
SAME_PLACE_DISTANCE = 1e-12
ARC_SAMPLES = 9  # times in each piece of a slow arc at which its load is computed


@dataclass(frozen=True)
class Manoeuvre:
    """One motion of the slider from rest to rest in the body. It begins `start` [s] into a plan.

    Parameters by kind, in SI units:

      line: w1, w2, t1, direction, position (signed along the direction from C, at the start)
      turn: radius, angular_acceleration, half_time, angle
      slow, straight: from_x, from_y, to_x, to_y, acceleration
      slow, round the circle: radius, from_angle, to_angle, angular_acceleration, rate
      wait: none
    """

    kind: ManoeuvreKind
    parameters: Mapping[str, float]
    path: SliderPath
    start: float = 0.0

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.path.duration


class TrackPlace(NamedTuple):
    """A place of the slider on a `part` of the track: its `point` x + iy relative to C [m] and, on
    the ARC, its `angle` [rad], which counts whole turns."""

    part: int
    point: complex
    angle: float = 0.0

    def differs_from(self, other: TrackPlace) -> bool:
        """Returns True if the slider has to move to reach the place `other`."""
        on_arc = self.part == other.part == ARC
        difference = self.angle - other.angle if on_arc else self.point - other.point
        return abs(difference) > SAME_PLACE_DISTANCE


@dataclass(frozen=True)
class Passage:
    """Manoeuvres that take the slider from the place `begin` of the track to the place `end`."""

    begin: TrackPlace
    end: TrackPlace
    manoeuvres: tuple[Manoeuvre, ...]

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return sum(manoeuvre.duration for manoeuvre in self.manoeuvres)


def wait(place: complex, duration: float) -> Manoeuvre:
    """Returns the manoeuvre that keeps the slider at `place` relative to C [m] for
    `duration` [s]."""
    return Manoeuvre("wait", {}, fixed((place.real, place.imag), duration))


def line_manoeuvre(
    direction: float, position: float, w1: float, w2: float, t1: float
) -> Manoeuvre:
    """Returns a line manoeuvre along `direction` [rad] that begins at `position` [m], signed along
    the direction from C (Chernousko 2020, eqs. 14-22)."""
    place = cmath.rect(position, direction)
    parameters = {"w1": w1, "w2": w2, "t1": t1, "direction": direction, "position": position}
    path = line_stroke((place.real, place.imag), direction, w1, w2, t1)
    return Manoeuvre("line", parameters, path)


def circle_manoeuvre(
    radius: float, angle: float, angular_acceleration: float, half_time: float
) -> Manoeuvre:
    """Returns a turn manoeuvre that begins at `angle` [rad] on the circle (Chernousko 2020, eqs.
    24-32)."""
    parameters = {
        "radius": radius,
        "angular_acceleration": angular_acceleration,
        "half_time": half_time,
        "angle": angle,
    }
    return Manoeuvre(
        "turn", parameters, arc_stroke(radius, angle, angular_acceleration, half_time)
    )


@lru_cache(maxsize=1024)
def slow_line(capsule: Capsule, start: complex, end: complex, holding: float) -> Manoeuvre:
    """Returns the fastest straight motion of the slider from `start` to `end` relative to C [m],
    with a constant acceleration and an equal deceleration that need at most the fraction `holding`
    of the friction limit.

    Along lines through C the limit is f g/mu (Chernousko 2020, eq. 21). On other lines the force
    also has a moment about the combined centre, and friction can balance only some wrenches. The
    limit is a concave function of the slider's place, so it is smallest at an end of one of the two
    halves.
    """
    direction = cmath.phase(end - start)
    length = abs(end - start)
    places = start, 0.5 * (start + end), end
    acceleration = holding * min(holding_limit(capsule, place, direction) for place in places)
    half = math.sqrt(length / acceleration)
    accelerations = (acceleration, -acceleration)
    path = straight((start.real, start.imag), direction, accelerations, (half, half))
    parameters = {
        "from_x": start.real,
        "from_y": start.imag,
        "to_x": end.real,
        "to_y": end.imag,
        "acceleration": acceleration,
    }
    return Manoeuvre("slow", parameters, path)


@lru_cache(maxsize=1024)
def slow_arc(
    capsule: Capsule, radius: float, start: float, end: float, holding: float
) -> Manoeuvre:
    """Returns a motion of the slider from angle `start` to `end` [rad] round the circle. It
    accelerates over a quarter of the arc, coasts over half and decelerates over a quarter. It needs
    at most the fraction `holding` of the friction limit.

    The motion is scaled in time to its largest load. On arcs of any length it takes at most 10 %
    more than the shortest possible time.
    """
    body = mechanics(capsule)
    swing = end - start

    def path(drive: float) -> SliderPath:
        """Returns the path with the angular acceleration `drive` [rad/s^2]."""
        ramp = math.sqrt(0.5 * abs(swing) / drive)
        drives = (math.copysign(drive, swing), 0.0, -math.copysign(drive, swing))
        return arc(radius, start, drives, (ramp, ramp, ramp))

    trial = capsule.holding_acceleration / radius
    excesses = list[float]()
    for piece in path(trial).pieces:
        for time in np.linspace(0.0, piece.duration, ARC_SAMPLES):
            excesses.append(excess_load(body, piece, float(time)))
    load = 1.0 + max(excesses)
    # At a given place all accelerations, and so the load, are in proportion to 1/duration^2.
    drive = trial * holding / load
    parameters = {
        "radius": radius,
        "from_angle": start,
        "to_angle": end,
        "angular_acceleration": math.copysign(drive, swing),
        "rate": math.copysign(math.sqrt(0.5 * abs(swing) * drive), swing),
    }
    return Manoeuvre("slow", parameters, path(drive))
