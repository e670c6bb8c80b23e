"""The manoeuvres that a plan is made of, as data: kind, parameters, the slider's path."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

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
from plumbob.analytic.systems.three_points.equations import Mechanics, mechanics
from plumbob.analytic.systems.three_points.rest import excess_load

Kind = Literal["slow", "turn", "line", "wait"]

ARC_SAMPLES = 9  # of each piece of a slow arc, for its largest load
ACROSS = 0.8  # of f g/mu: about the friction limit along a circle; selects a profile's shape


@dataclass(frozen=True)
class Manoeuvre:
    """One motion of the slider from rest to rest in the body; it begins `start` [s] into a plan.

    Parameters by kind, in SI: line w1, w2, t1, direction, position (signed along it from C, at the
    start); turn radius, angular_acceleration, half_time, angle; slow, straight from_x, from_y,
    to_x, to_y, acceleration; slow, round the circle radius, from_angle, to_angle,
    angular_acceleration, rate; wait none.
    """

    kind: Kind
    parameters: Mapping[str, float]
    path: SliderPath
    start: float = 0.0

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.path.duration


def wait(place: complex, duration: float) -> Manoeuvre:
    """The slider fixed at `place` relative to C [m] for `duration` [s]."""
    return Manoeuvre("wait", {}, fixed((place.real, place.imag), duration))


def line(direction: float, position: float, w1: float, w2: float, t1: float) -> Manoeuvre:
    """A line manoeuvre along `direction` [rad] from `position` [m] along it, from C (Chernousko
    2020, eqs. 14-22)."""
    place = cmath.rect(position, direction)
    given = {"w1": w1, "w2": w2, "t1": t1, "direction": direction, "position": position}
    path = line_stroke((place.real, place.imag), direction, w1, w2, t1)
    return Manoeuvre("line", given, path)


def turn(radius: float, angle: float, angular_acceleration: float, half_time: float) -> Manoeuvre:
    """A turn manoeuvre from `angle` [rad] on the circle (Chernousko 2020, eqs. 24-32)."""
    given = {
        "radius": radius,
        "angular_acceleration": angular_acceleration,
        "half_time": half_time,
        "angle": angle,
    }
    return Manoeuvre("turn", given, arc_stroke(radius, angle, angular_acceleration, half_time))


def _peak_load(body: Mechanics, path: SliderPath, samples: int) -> float:
    """Largest load factor of friction while the body rests, over `samples` of each piece."""
    return 1.0 + max(
        excess_load(body, piece, float(time), 0.0)
        for piece in path.pieces
        for time in np.linspace(0.0, piece.duration, samples)
    )


@lru_cache(maxsize=1024)
def slow_line(capsule: Capsule, start: complex, end: complex, holding: float) -> Manoeuvre:
    """The slider from `start` to `end` relative to C [m], straight, as quickly as a constant
    acceleration and deceleration allow that need at most the fraction `holding` of the friction
    limit.

    Along lines through C the limit is f g/mu (Chernousko 2020, eq. 21); elsewhere the force has a
    moment about the combined centre too, and the limit is that of the set of wrenches that friction
    can balance. This set is concave in the slider's place, so the ends of each half are decisive.
    """
    body, direction = mechanics(capsule), cmath.phase(end - start)
    place, length = (start.real, start.imag), abs(end - start)

    def path(acceleration: float) -> SliderPath:
        half = math.sqrt(length / acceleration)
        return straight(place, direction, (acceleration, -acceleration), (half, half))

    trial = capsule.holding_acceleration
    # At given places all accelerations go as 1/duration^2, and the load with them.
    acceleration = trial * holding / _peak_load(body, path(trial), 2)
    given = {
        "from_x": start.real,
        "from_y": start.imag,
        "to_x": end.real,
        "to_y": end.imag,
        "acceleration": acceleration,
    }
    return Manoeuvre("slow", given, path(acceleration))


@lru_cache(maxsize=1024)
def slow_arc(
    capsule: Capsule, radius: float, start: float, end: float, holding: float
) -> Manoeuvre:
    """The slider from angle `start` to `end` [rad] round the circle, speeding up, coasting and
    slowing down, needing at most the fraction `holding` of the friction limit.

    The fraction of the arc on which the speed changes is the quickest for a friction limit that is
    an ellipse; the motion is then scaled in time to its actual largest load.
    """
    body, swing, sense = mechanics(capsule), abs(end - start), math.copysign(1.0, end - start)
    fractions = np.linspace(0.02, 1.0, 99)
    drives = 1.0 / np.hypot(1.0 / ACROSS, fractions * swing)
    chosen = int(np.argmin((fractions**-0.5 + fractions**0.5) / np.sqrt(drives)))
    ramped, drive = float(fractions[chosen]), float(drives[chosen])

    def path(drive: float) -> SliderPath:
        ramp = math.sqrt(ramped * swing / drive)
        if ramped == 1.0:
            return arc(radius, start, (sense * drive, -sense * drive), (ramp, ramp))
        coast = swing * (1.0 - ramped) / (drive * ramp)
        drives = (sense * drive, 0.0, -sense * drive)
        return arc(radius, start, drives, (ramp, coast, ramp))

    trial = drive * capsule.holding_acceleration / radius
    drive = trial * holding / _peak_load(body, path(trial), ARC_SAMPLES)
    given = {
        "radius": radius,
        "from_angle": start,
        "to_angle": end,
        "angular_acceleration": sense * drive,
        "rate": sense * math.sqrt(ramped * swing * drive),
    }
    return Manoeuvre("slow", given, path(drive))
