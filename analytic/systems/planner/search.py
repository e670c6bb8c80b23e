"""The search for a plan of least time under given limits, whose end is where it is to be according
to the event-driven motion (`plumbob.analytic.systems.three_points.friction`)."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable
from dataclasses import replace

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.systems.capsule import Capsule, Segment, validity
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre
from plumbob.analytic.systems.planner.passages import (
    Passage,
    joined,
    quickest,
    translations,
    turning,
)
from plumbob.analytic.systems.planner.problem import (
    FULL_CIRCLE,
    Limits,
    RestPose,
    check_pushing,
    too_many,
)
from plumbob.analytic.systems.planner.result import Plan, TrackName
from plumbob.analytic.systems.planner.tracks import (
    ArcName,
    Curve,
    FreePlane,
    Pair,
    Track,
    check_curve,
)

SAME = 1e-12  # [m] and [rad]: a difference of poses this small needs no motion
LARGEST_HEADING = 1e6  # [rad]: 2 pi times so many turns is known to 1e-10
CLOSED = 1e-9  # [m] and [rad]: largest distance of the final pose from the goal
AIMS = 3  # corrections of the goal for accumulated round-off, before giving up


def plan(
    capsule: Capsule,
    goal: RestPose,
    limits: Limits | None = None,
    track: TrackName = "free",
    start: RestPose | None = None,
    *,
    equal: bool = False,
    legs: Pair = (1, 2),
    arc: ArcName = "shorter",
) -> Plan:
    """A plan from `start` (None: the origin, slider at C) to `goal`, turning the shorter way round.

    The plan has the least time found within `limits`; with `equal` it is a simple one instead: as
    few equal turns and lines as possible, w1 = 3 f g/mu, w2 = 0.8 f g/mu, mu_1 Z = 3 R_0, a slow
    return after each. On the track "curve" the slider goes along C-Ai and C-Aj, where i and j are
    the `legs`, and the `arc` between them. Raises ParameterError naming the limit that makes a pose
    unreachable, or the pose where the plan misses it.
    """
    limits = limits or Limits()
    start = start or RestPose(0.0, 0.0, 0.0)
    if track not in ("free", "curve"):
        raise ParameterError("track", track, "free or curve")
    for pose in (start, goal):
        if abs(pose.heading) > LARGEST_HEADING:
            raise ParameterError("heading", pose.heading, f"within ±{LARGEST_HEADING:g} rad")
    check_curve(legs, arc)
    rails: Track = (
        FreePlane(capsule, limits) if track == "free" else Curve(capsule, limits, legs, arc)
    )
    for breach in validity(capsule, (Segment(start.slider, goal.slider),)):
        raise breach
    aim = goal
    for _ in range(AIMS):
        made = _arranged(capsule, limits, rails, start, aim, equal)
        found = Plan(capsule, start, goal, limits, track, _in_order(made), legs, arc)
        if max(found.error) <= CLOSED:
            return found
        missed = goal.place - found.reached.place
        turned = math.remainder(goal.heading - found.reached.heading, FULL_CIRCLE)
        aim = RestPose(aim.x + missed.real, aim.y + missed.imag, aim.heading + turned, goal.slider)
    away, turned = found.error
    what = f"a pose that a plan reaches: the one found ends {away:.2g} m and {turned:.2g} rad away"
    raise ParameterError("to", [goal.x, goal.y, goal.heading], what)


def _in_order(made: Iterable[Manoeuvre]) -> tuple[Manoeuvre, ...]:
    """The manoeuvres with their times of start."""
    begun, placed = 0.0, list[Manoeuvre]()
    for manoeuvre in made:
        placed.append(replace(manoeuvre, start=begun))
        begun += manoeuvre.duration
    return tuple(placed)


def _arranged(
    capsule: Capsule, limits: Limits, track: Track, start: RestPose, aim: RestPose, equal: bool
) -> tuple[Manoeuvre, ...]:
    """Turns to the heading, then lines to the place, then the slider to its place: C moves with
    every turn, and a translation does not change the heading."""
    ways = [Passage(begin, begin, ()) for begin in track.places(start.slider)]
    wanted = math.remainder(aim.heading - start.heading, FULL_CIRCLE)
    place, heading = start.place, start.heading
    if abs(wanted) > SAME or abs(aim.place - place) > SAME:
        check_pushing(capsule, limits)
    if abs(wanted) > SAME:
        ahead = (aim.place - place) * cmath.rect(1.0, -heading)
        turned = turning(capsule, limits, track, wanted, ahead, equal=equal)
        ways = [quickest(joined(track, way, turned.passage) for way in ways)]
        place += cmath.rect(1.0, heading) * turned.shift
        heading += turned.heading
    left = (aim.place - place) * cmath.rect(1.0, -heading)
    if abs(left) > SAME:
        ways = [
            way
            for legs in track.legs(left)
            for way in translations(capsule, limits, track, ways, legs, equal=equal)
        ]
    ends = track.places(aim.slider)
    made = quickest(joined(track, way, Passage(end, end, ())) for way in ways for end in ends)
    count = sum(manoeuvre.kind in ("turn", "line") for manoeuvre in made.manoeuvres)
    if count > limits.manoeuvres:
        raise too_many(limits, count)
    return made.manoeuvres
