"""Translations of a plan: line manoeuvres along a rail, equal strokes and one remainder.

Body and slider move in opposite directions along a line through C (Chernousko 2020, eq. 22). For a
given displacement, a larger w1 and a larger w2 both shorten the stroke and the time, so the fastest
manoeuvre has both at their limits. Its time, return included, grows as the square root of the
displacement. So strokes of the largest length and one remainder cover a distance fastest.
"""

from __future__ import annotations

import math

from plumbob.analytic.systems.manoeuvres.line_manoeuvre import closed_form
from plumbob.analytic.systems.planner.manoeuvre import Passage, line_manoeuvre
from plumbob.analytic.systems.planner.problem import too_many
from plumbob.analytic.systems.planner.tracks import Rail, Track

# places of a stroke on a rail: fraction of the free length before it
STROKE_PLACES = (0.0, 0.5, 1.0)


def line_time(track: Track, displacement: complex) -> float:
    """Returns the estimated time [s] of lines with slow returns that move the body by
    `displacement` [m], in body axes: strokes of the largest length and one for the remainder. The
    time of a stroke is proportional to the square root of its length."""
    unit = track.unit_line
    total = 0.0
    for rail, distance in track.legs(displacement)[0]:
        stroke = min(track.limits.stroke, rail.high - rail.low)
        distance_per_stroke = -unit.displacement * stroke / unit.stroke
        remainder, count = math.modf(distance / distance_per_stroke)
        return_time = 2.0 * math.sqrt(stroke / track.w2)
        stroke_time = unit.t2 * math.sqrt(stroke / unit.stroke) + return_time
        total += stroke_time * (count + math.sqrt(remainder))
    return total


def strokes(track: Track, rail: Rail, distance: float) -> list[tuple[Passage, ...]]:
    """Returns a few ways to move the body by `distance` [m]: line manoeuvres of the largest stroke
    and one for the remainder. The ways differ in the place of the strokes on the `rail`. Raises
    ParameterError."""
    unit = track.unit_line
    longest = min(track.limits.stroke, rail.high - rail.low)
    w1 = track.limits.acceleration
    w2 = track.w2
    largest = -unit.displacement * longest / unit.stroke
    count = math.ceil(distance / largest * (1.0 - 1e-12))
    if count > track.limits.manoeuvres:
        raise too_many(track.limits, count)

    def passage(part: float, fraction_before: float) -> Passage:
        """Returns the line manoeuvre that moves the body by `part` [m], at a place of STROKE_PLACES
        on the rail."""
        t1 = math.sqrt(part / -unit.displacement)
        length = closed_form(track.capsule, w1, w2, t1).stroke
        begin = rail.low + fraction_before * max(rail.high - rail.low - length, 0.0)
        manoeuvre = line_manoeuvre(rail.direction, begin, w1, w2, t1)
        return Passage(rail.place(begin), rail.place(begin + length), (manoeuvre,))

    parts = [largest] * (count - 1) + [distance - (count - 1) * largest]
    ways = list[tuple[Passage, ...]]()
    for fraction_before in STROKE_PLACES:
        ways.append(tuple(passage(part, fraction_before) for part in parts))
    return ways
