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
from plumbob.analytic.systems.planner.manoeuvre import Passage, slow_arc, turn, wait
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, to_ten_digits, too_many
from plumbob.analytic.systems.planner.tracks import Circle, Track
from plumbob.analytic.systems.three_points.friction import three_point_motion

WAITING = 1.1  # wait after a turn over the time of the residual motion
SURVEYED = 8  # number of turns that are computed for the estimates
SMALLEST = 1 / 24  # slider's angle in the smallest of these turns over that in the largest
# Assumed heading of the largest turn over its surveyed value: it depends on where the turn begins.
LIKELY = 0.98
LARGER = 1.1  # largest angle of the slider in an exact turn over its estimate
MORE = 15  # numbers of turns that are tried beyond the smallest
AGREED = 1e-14  # relative accuracy of the slider's angle in an exact turn


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
def computed_turn(track: Track, start: float, swing: float) -> Turn:
    """Returns a turn from rest, computed to rest. The slider starts at angle `start` and moves
    through `swing` [rad], of either sign."""
    # The largest |w| is at half time, where the centripetal acceleration is a Z |swing|.
    acceleration = track.limits.acceleration / (track.limits.radius * math.hypot(1.0, swing))
    half_time = math.sqrt(abs(swing) / acceleration)
    made = turn(track.limits.radius, start, math.copysign(acceleration, swing), half_time)
    motion = three_point_motion(track.capsule, made.path)
    pose = motion.at(np.array([motion.rest_time]))
    begin = track.on_circle(start)
    end = track.on_circle(start + swing)
    pause = WAITING * (motion.rest_time - made.duration)
    waits = (wait(end.point, pause),) if pause > 0.0 else ()
    passage = Passage(begin, end, (made, *waits))
    return Turn(passage, swing, float(pose.heading[0]), complex(*pose.position[0]))


def exact_turn(
    track: Track,
    circle: Circle,
    start: Callable[[float], float],
    longest: float,
    wanted: float,
) -> Turn | None:
    """Returns the turn that adds the heading `wanted` [rad], a positive number. `start` gives the
    angle at which to begin for each angle of the slider. Returns None if the slider's angle would
    have to exceed `longest` [rad]."""
    from scipy.optimize import brentq

    def turn_of(swing: float) -> Turn:
        return computed_turn(track, start(swing), circle.sense * swing)

    def excess(swing: float) -> float:
        return circle.gained(turn_of(swing).heading if swing else 0.0) - wanted

    if wanted <= 0.0 or excess(longest) < 0.0:
        return None
    root = brentq(excess, 0.0, longest, xtol=AGREED * longest, rtol=4 * np.finfo(float).eps)
    return turn_of(float(root))


class Choice(NamedTuple):
    """A number of `turns`, each with the slider through about `swing` [rad], the first one from the
    start number `place` of the circle. `time` [s] is the estimate for these turns and the lines
    after them, to ten digits."""

    time: float
    turns: int
    place: int
    swing: float


def choices(track: Track, circle: Circle, wanted: float, displacement: complex) -> list[Choice]:
    """Returns ways to turn the body by `wanted` [rad], a positive number, and to move C in all by
    `displacement` [m], in body axes at the start. Raises ParameterError.

    Each time is estimated from a few computed turns: heading and shift of a turn are nearly in
    proportion to the slider's angle, its time to the square root.
    """
    ways = list[Choice]()
    turns = _survey(track, circle)
    fewest = math.ceil(wanted / (LIKELY * circle.gained(turns[-1].heading)))
    most = min(fewest + MORE, track.limits.manoeuvres)
    for count in range(fewest, most + 1):
        swing, shift, time = _between(turns, circle, wanted / count)
        time = count * time
        turned = -wanted / count
        if circle.extent is None:
            turned += swing
        else:
            back = slow_arc(
                track.capsule, track.limits.radius, 0.0, swing, track.limits.holding
            )
            time += (count - 1) * back.duration
        drift = shift * complex(np.exp(1j * circle.sense * turned * np.arange(count)).sum())
        for place, start in enumerate(circle.starts(swing)):
            left = displacement - drift * cmath.rect(1.0, start)
            left *= cmath.rect(1.0, circle.sense * wanted)
            estimate = to_ten_digits(time + line_time(track, left))
            ways.append(Choice(estimate, count, place, swing))
    if not ways:
        raise too_many(track.limits, fewest)
    return ways


def _between(turns: list[Turn], circle: Circle, wanted: float) -> tuple[float, complex, float]:
    """Returns estimates for a turn that adds the heading `wanted` [rad], interpolated between
    computed turns: the slider's angle [rad], the shift of C [m] if the slider starts on the body's
    x axis, and the time [s]."""
    swings = np.array([abs(turn.swing) for turn in turns])
    gains = np.array([circle.gained(turn.heading) for turn in turns])
    swing = wanted * float(np.interp(wanted, gains, swings / gains))
    shifts = np.array([turn.shift for turn in turns]) * cmath.rect(1.0, -circle.first)
    times = np.array([turn.passage.duration for turn in turns])
    shift = swing * complex(np.interp(swing, swings, shifts / swings))
    return (
        swing,
        shift,
        math.sqrt(swing) * float(np.interp(swing, swings, times / np.sqrt(swings))),
    )


def _survey(track: Track, circle: Circle) -> list[Turn]:
    """Returns a few turns, from a small one to the one that turns the body most. Raises
    ParameterError naming the acceleration if larger turns of the slider do not turn the body more.
    """
    if not SMALLEST * circle.longest > 0.0:
        raise ParameterError("stroke", track.limits.stroke, "large enough for a turn")
    swings = circle.sense * np.geomspace(SMALLEST * circle.longest, circle.longest, SURVEYED)
    turns = [computed_turn(track, circle.first, float(swing)) for swing in swings]
    gains = [0.0, *(circle.gained(turn.heading) for turn in turns)]
    count = int(np.argmax(gains))
    if count == 0 or np.any(np.diff(gains[: count + 1]) <= 0.0):
        need = f"large enough to turn the body with a slider {track.limits.radius:g} m from C"
        raise ParameterError("acceleration", track.limits.acceleration, need)
    return turns[:count]


def turns_of(track: Track, circle: Circle, wanted: float, choice: Choice) -> list[Turn] | None:
    """Returns the turns of a choice, which together add exactly the heading `wanted` [rad], a
    positive number. If all begin at one place, they are equal; otherwise the last one differs.
    Returns None if a turn would be too large."""
    longest = min(LARGER * choice.swing, circle.longest)
    turns = list[Turn]()

    def start(swing: float) -> float:
        if turns:
            return math.remainder(turns[-1].passage.end.angle, FULL_CIRCLE)
        return float(circle.starts(swing)[choice.place])

    if circle.extent is not None:
        turn = exact_turn(track, circle, start, longest, wanted / choice.turns)
        return None if turn is None else [turn] * choice.turns
    while len(turns) < choice.turns - 1:
        swing = circle.sense * choice.swing
        turns.append(computed_turn(track, start(swing), swing))
    left = wanted - sum(circle.gained(turn.heading) for turn in turns)
    last = exact_turn(track, circle, start, longest, left)
    return None if last is None else [*turns, last]


def turns_to(track: Track, wanted: float, displacement: complex) -> list[Turn]:
    """Returns turns that add the heading `wanted` [rad]. `displacement` [m], in body axes, is the
    total of turns and lines. Raises ParameterError."""
    sense = -math.copysign(1.0, wanted)
    size = abs(wanted)
    for returning in (False, True):  # turns from one place are the fallback
        circle = track.circle(sense, returning=returning)
        ways = choices(track, circle, size, displacement)
        best = min(ways)
        if turns := turns_of(track, circle, size, best):
            return turns
    raise too_many(track.limits, best.turns + 1)
