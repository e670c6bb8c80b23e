"""The construction of a plan as in the source: turns to the heading, lines to the position, slow
motions between. The event-driven motion (`plumbob.analytic.systems.three_points.friction`) gives
the pose at its end."""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.systems.capsule import Capsule, check_loads
from plumbob.analytic.systems.planner.lines import strokes
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre, Passage
from plumbob.analytic.systems.planner.problem import (
    FULL_CIRCLE,
    Limits,
    RestPose,
    check_pushing,
    to_ten_digits,
    too_many,
)
from plumbob.analytic.systems.planner.result import Plan, TrackName
from plumbob.analytic.systems.planner.tracks import ArcName, Ends, LineSegment, Pair, Track
from plumbob.analytic.systems.planner.turns import Turn, turns_to

NO_MOTION = 1e-12  # [m] and [rad] largest difference of poses that needs no motion
LARGEST_HEADING = 1e6  # [rad] as a double it is known to 1e-10, modulo whole turns
POSE_TOLERANCE = 1e-9  # [m] and [rad] largest distance of the final pose from the goal


def plan(
    capsule: Capsule,
    goal: RestPose,
    limits: Limits | None = None,
    track: TrackName = "free",
    start: RestPose | None = None,
    *,
    legs: Pair = (1, 2),
    arc: ArcName | Ends = "shorter",
    segments: tuple[LineSegment, ...] | None = None,
) -> Plan:
    """Returns the fastest of a few plans from `start` to `goal` that turn the shorter way. If
    `start` is None, the plan begins at the origin with heading 0 and the slider at C.

    On the track "curve" the lines are along the supports' directions `legs`, or along two
    `segments` of lines through C; the turns are on the `arc`, given by name or as two angles [rad].
    Raises ParameterError naming the limit that makes a pose unreachable, or the pose if the plan
    misses it.
    """
    limits = limits or Limits()
    start = start or RestPose(0.0, 0.0, 0.0)
    for pose in (start, goal):
        if abs(pose.heading) > LARGEST_HEADING:
            raise ParameterError("heading", pose.heading, f"within ±{LARGEST_HEADING:g} rad")
    empty = Plan(
        capsule=capsule,
        start=start,
        goal=goal,
        limits=limits,
        track=track,
        manoeuvres=(),
        legs=legs,
        arc=arc,
        segments=segments,
    )
    rails = empty.rails
    check_loads(capsule, (start.slider, goal.slider))
    plan = replace(empty, manoeuvres=_find_manoeuvres(rails, start, goal))
    distance, angle = plan.error
    if max(distance, angle) > POSE_TOLERANCE:
        ends = f"the one found ends {distance:.2g} m and {angle:.2g} rad away"
        need = f"a pose that a plan reaches: {ends}"
        raise ParameterError("to", [goal.x, goal.y, goal.heading], need)
    return plan


def _find_manoeuvres(track: Track, start: RestPose, goal: RestPose) -> tuple[Manoeuvre, ...]:
    """Returns the manoeuvres of a plan: turns to the heading, lines to the position, and slow
    motions of the slider between them and to its final place. The turns come first: C moves with
    every turn, and a translation does not change the heading."""
    heading = math.remainder(goal.heading - start.heading, FULL_CIRCLE)
    displacement = (goal.place - start.place) * cmath.rect(1.0, -start.heading)
    turns = list[Turn]()
    if abs(heading) > NO_MOTION or abs(displacement) > NO_MOTION:
        check_pushing(track.capsule, track.limits)
    if abs(heading) > NO_MOTION:
        turns = turns_to(track, heading, displacement)
    for turn in turns:
        displacement = (displacement - turn.shift) * cmath.rect(1.0, -turn.heading)
    passages = [turn.passage for turn in turns]
    manoeuvres = _fastest_way(track, start, goal, passages, displacement).manoeuvres
    count = sum(manoeuvre.kind in ("turn", "line") for manoeuvre in manoeuvres)
    if count > track.limits.manoeuvres:
        raise too_many(track.limits, count)
    durations = (manoeuvre.duration for manoeuvre in manoeuvres)
    starts = itertools.accumulate(durations, initial=0.0)
    return tuple(replace(m, start=begin) for m, begin in zip(manoeuvres, starts, strict=False))


def _fastest_way(
    track: Track,
    start: RestPose,
    goal: RestPose,
    turns: Sequence[Passage],
    displacement: complex,
) -> Passage:
    """Returns the fastest way of the slider from its place in `start`, through the `turns`, through
    lines that move the body by `displacement` [m], in body axes, to its place in `goal`."""
    choices = itertools.product(
        track.places(start.slider),
        _translations(track, displacement),
        track.places(goal.slider),
    )
    ways = list[Passage]()
    for begin, lines, end in choices:
        first = Passage(begin, begin, ())
        last = Passage(end, end, ())
        ways.append(_join(track, [first, *turns, *lines, last]))
    return min(ways, key=lambda way: to_ten_digits(way.duration))


def _translations(track: Track, displacement: complex) -> list[tuple[Passage, ...]]:
    """Returns ways to move the body by `displacement` [m], in body axes. Each way is a sequence of
    lines along one leg of the track after another."""
    if abs(displacement) <= NO_MOTION:
        return [()]
    ways = list[tuple[Passage, ...]]()
    for legs in track.legs(displacement):
        ways_along_legs = list[list[Passage]]()
        for rail, distance in legs:
            ways_along_legs.append(
                [_join(track, way) for way in strokes(track, rail, distance)]
            )
        ways += itertools.product(*ways_along_legs)
    return ways


def _join(track: Track, passages: Sequence[Passage]) -> Passage:
    """Returns one passage: the `passages` in order, with slow motions of the slider
    between them."""
    manoeuvres = [*passages[0].manoeuvres]
    for before, after in itertools.pairwise(passages):
        manoeuvres += [*track.route(before.end, after.begin), *after.manoeuvres]
    return Passage(passages[0].begin, passages[-1].end, tuple(manoeuvres))
