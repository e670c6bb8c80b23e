"""Passages of a plan: turns with their waits and returns, lines with theirs, joined slowly."""

from __future__ import annotations

import cmath
from collections.abc import Iterable
from dataclasses import dataclass

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.planner.lines import (
    TO_SPARE,
    Stroke,
    common_push,
    push_times,
    quickest_push,
    strokes,
)
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre, slow_arc, wait
from plumbob.analytic.systems.planner.problem import Limits
from plumbob.analytic.systems.planner.schedule import first_of_least, turns
from plumbob.analytic.systems.planner.tracks import Legs, Track
from plumbob.analytic.systems.planner.turns import common_drive, equal_turns, quickest_drive
from plumbob.analytic.systems.three_points.equations import Complex


@dataclass(frozen=True)
class Passage:
    """Manoeuvres that take the slider from one of the track's places to another."""

    begin: complex
    end: complex
    manoeuvres: tuple[Manoeuvre, ...]

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return sum(manoeuvre.duration for manoeuvre in self.manoeuvres)


@dataclass(frozen=True)
class Turning:
    """All turns of a plan: heading gained [rad], shift of C in the body axes of their start [m]."""

    passage: Passage
    heading: float
    shift: complex


def joined(track: Track, first: Passage, second: Passage) -> Passage:
    """One passage after another, with slow motions of the slider between them."""
    between = track.route(first.end, second.begin)
    made = (*first.manoeuvres, *between, *second.manoeuvres)
    return Passage(first.begin, second.end, made)


def quickest(ways: Iterable[Passage]) -> Passage:
    """The passage of least duration, the first of equals."""
    return first_of_least(ways, lambda way: way.duration)


def turning(
    capsule: Capsule,
    limits: Limits,
    track: Track,
    wanted: float,
    displacement: complex,
    *,
    equal: bool,
) -> Turning:
    """Turns for the heading `wanted` [rad]; `displacement` [m] in body axes is the total of turns
    and lines. Each turn is followed by a wait for the residual motion to end and, where the next
    one needs it, by a slow return."""
    circle = track.circle(-1.0 if wanted > 0.0 else 1.0, returning=equal)
    if equal:
        found = equal_turns(capsule, limits, circle, wanted, common_drive(capsule, limits))
    else:
        push, drive = quickest_push(capsule, limits), quickest_drive(limits)

        def lines(displacements: Complex) -> Array:
            return track.line_time(push, displacements)

        found = tuple(turns(capsule, limits, circle, drive, wanted, displacement, lines))
    made, heading, shift = list[Manoeuvre](), 0.0, 0j
    begin = angle = found[0].manoeuvre.parameters["angle"]
    for one in found:
        begun = one.manoeuvre.parameters["angle"]
        if circle.extent is not None and begun != angle:
            made.append(slow_arc(capsule, limits.radius, angle, begun, limits.holding))
        angle = begun + one.swing
        made.append(one.manoeuvre)
        if one.pause > 0.0:
            made.append(wait(cmath.rect(limits.radius, angle), one.pause))
        shift += cmath.rect(1.0, heading) * one.shift
        heading += one.heading
    passage = Passage(track.on_circle(begin), track.on_circle(angle), tuple(made))
    return Turning(passage, heading, shift)


def translations(
    capsule: Capsule,
    limits: Limits,
    track: Track,
    ways: Iterable[Passage],
    legs: Legs,
    *,
    equal: bool,
) -> list[Passage]:
    """`ways` continued along every leg, in each order and from each of a few places on its rail:
    the quickest to each place where the last leg may end."""
    push = (common_push if equal else quickest_push)(capsule, limits)
    found = list(ways)
    for rail, distance in legs:
        longest = min(limits.stroke, rail.high - rail.low)
        times = push_times(capsule, limits, push, longest, distance, equal=equal)
        tries = [(times, 0.5)] if equal else [
            (order, spare) for order in dict.fromkeys([times, times[::-1]]) for spare in TO_SPARE
        ]  # fmt: skip
        options = [_passage(track, strokes(capsule, rail, push, *one)) for one in tries]
        found = [quickest(joined(track, way, option) for way in found) for option in options]
    return found


def _passage(track: Track, made: tuple[Stroke, ...]) -> Passage:
    """The strokes, with slow returns of the slider between them."""
    whole = Passage(made[0].begin, made[0].end, (made[0].manoeuvre,))
    for one in made[1:]:
        whole = joined(track, whole, Passage(one.begin, one.end, (one.manoeuvre,)))
    return whole
