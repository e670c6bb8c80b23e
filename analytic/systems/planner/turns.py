"""Turns of a plan: equal turns, each computed to rest. Their number and first place are the best of
a few choices by an estimate of the time.

Formulas 24-32 of Chernousko 2020 apply as epsilon -> 0. A limit on |w| bounds epsilon from below,
so every turn is computed by `three_points.friction` until the residual motion has ended. Every turn
also shifts C, by centimetres, and lines have to correct this. So the time of the lines counts in
the choice. On a free plane the slider continues round the circle and the shifts cancel.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.systems.planner.lines import line_time
from plumbob.analytic.systems.planner.manoeuvre import Passage, circle_manoeuvre, slow_arc, wait
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, to_ten_digits, too_many
from plumbob.analytic.systems.planner.tracks import Circle, Track
from plumbob.analytic.systems.three_points.friction import three_point_motion

WAIT_FACTOR = 1.1  # ratio of the wait after a turn to the time of the residual motion
SURVEY_TURNS = 8  # number of turns that are computed for the estimates
# Ratio of the slider's angle in the smallest surveyed turn to its angle in the largest
SMALLEST_TURN_RATIO = 1 / 24
# Assumed ratio of the heading of the largest turn to its surveyed value. The heading depends on
# where the turn begins.
HEADING_MARGIN = 0.98
# Largest ratio of the slider's angle in an exact turn to its estimate
LARGEST_OVER_ESTIMATE = 1.1
EXTRA_COUNTS = 15  # numbers of turns that are tried beyond the smallest
ANGLE_TOLERANCE = 1e-14  # relative accuracy of the slider's angle in an exact turn


@dataclass(frozen=True)
class Turn:
    """A turn manoeuvre of the slider through the angle `swing` [rad], with a wait for the body to
    come to rest. `heading` [rad] and `shift` of C [m], in body axes at the start, are what the turn
    adds."""

    passage: Passage
    swing: float
    heading: float
    shift: complex


@lru_cache(maxsize=256)
def compute_turn(track: Track, start: float, swing: float) -> Turn:
    """Returns a turn from rest, computed to rest. The slider starts at angle `start` and moves
    through `swing` [rad], of either sign."""
    # The largest |w| is at half time, where the centripetal acceleration is a Z |swing|.
    acceleration = track.limits.acceleration / (track.limits.radius * math.hypot(1.0, swing))
    half_time = math.sqrt(abs(swing) / acceleration)
    manoeuvre = circle_manoeuvre(
        track.limits.radius, start, math.copysign(acceleration, swing), half_time
    )
    motion = three_point_motion(track.capsule, manoeuvre.path)
    pose = motion.at(np.array([motion.rest_time]))
    begin = track.on_circle(start)
    end = track.on_circle(start + swing)
    pause = WAIT_FACTOR * (motion.rest_time - manoeuvre.duration)
    waits = (wait(end.point, pause),) if pause > 0.0 else ()
    passage = Passage(begin, end, (manoeuvre, *waits))
    return Turn(passage, swing, float(pose.heading[0]), complex(*pose.position[0]))


def exact_turn(
    track: Track,
    circle: Circle,
    start: Callable[[float], float],
    longest: float,
    heading: float,
) -> Turn | None:
    """Returns the turn that adds the `heading` [rad], a positive number. `start` gives the angle at
    which to begin for each angle of the slider. Returns None if the slider's angle would have to
    exceed `longest` [rad]."""
    from scipy.optimize import brentq

    def turn_through(swing: float) -> Turn:
        """Returns the turn with the slider through `swing` [rad]."""
        return compute_turn(track, start(swing), circle.sense * swing)

    def excess(swing: float) -> float:
        """Returns by how much the turn of the slider through `swing` [rad] exceeds the heading
        [rad]."""
        turned = turn_through(swing).heading if swing else 0.0
        return circle.heading_gain(turned) - heading

    if heading <= 0.0 or excess(longest) < 0.0:
        return None
    tolerance = ANGLE_TOLERANCE * longest
    root = brentq(excess, 0.0, longest, xtol=tolerance, rtol=4 * np.finfo(float).eps)
    return turn_through(float(root))


class TurnChoice(NamedTuple):
    """A number of `turns`, each with the slider through about `swing` [rad], the first one from the
    start number `place` of the circle. `time` [s] is the estimate for these turns and the lines
    after them, to ten digits."""

    time: float
    turns: int
    place: int
    swing: float


def estimate_choices(
    track: Track, circle: Circle, heading: float, displacement: complex
) -> list[TurnChoice]:
    """Returns ways to turn the body by `heading` [rad], a positive number, and to move C in all by
    `displacement` [m], in body axes at the start. Raises ParameterError.

    Each time is estimated from a few computed turns: heading and shift of a turn are nearly in
    proportion to the slider's angle, its time to the square root.
    """
    choices = list[TurnChoice]()
    turns = _survey_turns(track, circle)
    fewest = math.ceil(heading / (HEADING_MARGIN * circle.heading_gain(turns[-1].heading)))
    most = min(fewest + EXTRA_COUNTS, track.limits.manoeuvres)
    for count in range(fewest, most + 1):
        swing, shift, time = _interpolate_turn(turns, circle, heading / count)
        time *= count
        # From turn to turn the shift of C rotates with the body, and with the slider's place.
        rotation = -heading / count
        if circle.extent is None:
            rotation += swing
        else:
            time += (count - 1) * _return_time(track, swing)
        rotations = np.exp(1j * circle.sense * rotation * np.arange(count))
        total_shift = shift * complex(rotations.sum())
        for place, start in enumerate(circle.starts(swing)):
            remaining = displacement - total_shift * cmath.rect(1.0, start)
            remaining *= cmath.rect(1.0, circle.sense * heading)  # in body axes after the turns
            estimate = to_ten_digits(time + line_time(track, remaining))
            choices.append(TurnChoice(estimate, count, place, swing))
    if not choices:
        raise too_many(track.limits, fewest)
    return choices


def _return_time(track: Track, swing: float) -> float:
    """Returns the time [s] in which the slider slowly moves round the circle through
    `swing` [rad]."""
    radius = track.limits.radius
    return slow_arc(track.capsule, radius, 0.0, swing, track.limits.holding).duration


def _interpolate_turn(
    turns: list[Turn], circle: Circle, heading: float
) -> tuple[float, complex, float]:
    """Returns estimates for a turn that adds the `heading` [rad], interpolated between computed
    turns: the slider's angle [rad], the shift of C [m] if the slider starts on the body's x axis,
    and the time [s]."""
    swings = np.array([abs(turn.swing) for turn in turns])
    gains = np.array([circle.heading_gain(turn.heading) for turn in turns])
    swing = heading * float(np.interp(heading, gains, swings / gains))
    shifts = np.array([turn.shift for turn in turns]) * cmath.rect(1.0, -circle.first)
    shift = swing * complex(np.interp(swing, swings, shifts / swings))
    times = np.array([turn.passage.duration for turn in turns])
    time = math.sqrt(swing) * float(np.interp(swing, swings, times / np.sqrt(swings)))
    return swing, shift, time


def _survey_turns(track: Track, circle: Circle) -> list[Turn]:
    """Returns a few turns, from a small one to the one that turns the body most. Raises
    ParameterError naming the acceleration if larger turns of the slider do not turn the body more.
    """
    smallest = SMALLEST_TURN_RATIO * circle.longest
    if not smallest > 0.0:
        raise ParameterError("stroke", track.limits.stroke, "large enough for a turn")
    swings = circle.sense * np.geomspace(smallest, circle.longest, SURVEY_TURNS)
    turns = [compute_turn(track, circle.first, float(swing)) for swing in swings]
    gains = [0.0, *(circle.heading_gain(turn.heading) for turn in turns)]
    count = int(np.argmax(gains))
    if count == 0 or np.any(np.diff(gains[: count + 1]) <= 0.0):
        need = f"large enough to turn the body with a slider {track.limits.radius:g} m from C"
        raise ParameterError("acceleration", track.limits.acceleration, need)
    return turns[:count]


def turns_of_choice(
    track: Track, circle: Circle, heading: float, choice: TurnChoice
) -> list[Turn] | None:
    """Returns the turns of a choice, which together add exactly the `heading` [rad], a positive
    number. If all begin at one place, they are equal; otherwise the last one differs. Returns None
    if a turn would be too large."""
    longest = min(LARGEST_OVER_ESTIMATE * choice.swing, circle.longest)
    turns = list[Turn]()

    def start(swing: float) -> float:
        """Returns the angle [rad] at which the next turn, through `swing` [rad], begins."""
        if turns:
            return math.remainder(turns[-1].passage.end.angle, FULL_CIRCLE)
        return float(circle.starts(swing)[choice.place])

    if circle.extent is not None:
        turn = exact_turn(track, circle, start, longest, heading / choice.turns)
        return None if turn is None else [turn] * choice.turns
    while len(turns) < choice.turns - 1:
        swing = circle.sense * choice.swing
        turns.append(compute_turn(track, start(swing), swing))
    remaining = heading - sum(circle.heading_gain(turn.heading) for turn in turns)
    last = exact_turn(track, circle, start, longest, remaining)
    return None if last is None else [*turns, last]


def turns_to(track: Track, heading: float, displacement: complex) -> list[Turn]:
    """Returns turns that add the `heading` [rad]. `displacement` [m], in body axes, is the total of
    turns and lines. Raises ParameterError."""
    sense = -math.copysign(1.0, heading)
    size = abs(heading)
    for returning in (False, True):  # turns from one place are the fallback
        circle = track.circle(sense, returning=returning)
        best = min(estimate_choices(track, circle, size, displacement))
        turns = turns_of_choice(track, circle, size, best)
        if turns:
            return turns
    raise too_many(track.limits, best.turns + 1)
