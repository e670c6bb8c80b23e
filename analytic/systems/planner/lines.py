"""Translations of a plan: line manoeuvres along straight parts of the track, chosen for least time.

Body and slider go opposite ways along a line through C (Chernousko 2020, eq. 22). For a given
displacement a larger w1 and a larger w2 both shorten the stroke and the time, so the quickest
manoeuvre has them at their limits; its time, return included, grows as the root of the
displacement, so whole strokes and one remainder cover a distance quickest."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import ClosedForm, closed_form
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre, line
from plumbob.analytic.systems.planner.problem import Limits, too_many

TO_SPARE = (0.0, 0.5, 1.0)  # fractions of a rail's spare length at which a stroke begins


@dataclass(frozen=True)
class Rail:
    """A straight part of the track on a line through C: the slider may go in `direction` [rad, from
    the body's x axis] from `low` to `high`, signed along it from C [m]; `place` names the track's
    place there."""

    direction: float
    low: float
    high: float
    place: Callable[[float], complex]


@dataclass(frozen=True)
class Push:
    """Accelerations of a line manoeuvre [m/s^2]."""

    w1: float
    w2: float


@dataclass(frozen=True)
class Stroke:
    """A line manoeuvre, and the track's places where the slider begins and ends."""

    manoeuvre: Manoeuvre
    begin: complex
    end: complex


def quickest_push(capsule: Capsule, limits: Limits) -> Push:
    """The largest w1 and w2 within the limits."""
    return Push(limits.acceleration, limits.holding * capsule.holding_acceleration)


def common_push(capsule: Capsule, limits: Limits) -> Push:
    """Three times the friction limit f g/mu, and 0.8 of it, within the limits."""
    threshold = capsule.holding_acceleration
    return Push(min(3.0 * threshold, limits.acceleration), min(0.8, limits.holding) * threshold)


@lru_cache(maxsize=64)
def unit_line(capsule: Capsule, push: Push) -> ClosedForm:
    """The line manoeuvre with t1 = 1 s: displacements scale with t1^2, times with t1."""
    return closed_form(capsule, push.w1, push.w2, 1.0)


def push_times(
    capsule: Capsule,
    limits: Limits,
    push: Push,
    longest: float,
    distance: float,
    *,
    equal: bool,
) -> tuple[float, ...]:
    """t1 [s] of every line manoeuvre that together move the body by `distance` [m] with strokes
    of at most `longest` [m]: whole strokes and a remainder, or `equal` ones. Raises
    ParameterError."""
    unit = unit_line(capsule, push)
    whole = -unit.displacement * longest / unit.stroke
    count = math.ceil(distance / whole * (1.0 - 1e-12))
    if count > limits.manoeuvres:
        raise too_many(limits, count)
    parts = [distance / count] * count
    if not equal:
        parts = [whole] * (count - 1) + [distance - (count - 1) * whole]
    return tuple(math.sqrt(part / -unit.displacement) for part in parts)


def line_time(
    capsule: Capsule, limits: Limits, push: Push, longest: float, distances: Array
) -> Array:
    """Estimated time [s], shape (n,), of lines with slow returns for `distances` [m], shape
    (n,)."""
    unit = unit_line(capsule, push)
    whole = -unit.displacement * longest / unit.stroke
    back = 2.0 * math.sqrt(longest / (limits.holding * capsule.holding_acceleration))
    cycle = unit.t2 * math.sqrt(longest / unit.stroke) + back
    count = np.floor(distances / whole)
    return np.asarray(cycle * (count + np.sqrt(distances / whole - count)))


def strokes(
    capsule: Capsule, rail: Rail, push: Push, times: tuple[float, ...], spare: float
) -> tuple[Stroke, ...]:
    """Line manoeuvres on `rail` with t1 each of `times` [s]; one shorter than the rail begins at
    the fraction `spare` of the length it leaves."""
    made = []
    for t1 in times:
        length = closed_form(capsule, push.w1, push.w2, t1).stroke
        begin = rail.low + spare * max(rail.high - rail.low - length, 0.0)
        manoeuvre = line(rail.direction, begin, push.w1, push.w2, t1)
        made.append(Stroke(manoeuvre, rail.place(begin), rail.place(begin + length)))
    return tuple(made)
