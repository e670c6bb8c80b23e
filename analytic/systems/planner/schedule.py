"""Which turns to make: sizes and places for least total time, the last one closing the heading.

Every turn shifts C as well, by centimetres, and lines must make good what is left: so the time of
the lines counts in the choice of the turns. On a free plane the slider goes on round the circle and
the shifts cancel; on an arc its returns cost time, and where on the arc a turn is made decides
which way C goes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, Limits, too_many
from plumbob.analytic.systems.planner.turns import (
    Circle,
    Drive,
    Outcome,
    Survey,
    exact_turn,
    outcome,
    survey,
)
from plumbob.analytic.systems.three_points.equations import Complex

SIZES = 33  # tried of the turns before the last, for each number of turns
MORE = 12  # turns tried beyond what the quickest turning of the body alone takes
LEAST = 0.2  # of an even share of the heading, for the turns before the last
SPARE = 1.05  # times the arc that the last turn is thought to need
SHARES = (0.0, 0.5, 1.0)  # of the arc that a turn leaves, tried before its start

LineTime = Callable[[Complex], Array]
"""Displacements of the body in its axes [m], shape (n,) -> about the time of the lines [s]."""


@dataclass(frozen=True)
class Next:
    """The turn to make now, as one of `count` that remain: slider's angle `swing` from `start`
    [rad], and the estimated time of all that remains [s]."""

    count: int
    swing: float
    start: float
    time: float


def schedule(
    seen: Survey,
    circle: Circle,
    wanted: float,
    displacement: complex,
    line_time: LineTime,
    most: int | None = None,
) -> Next:
    """The turn to begin with for the heading `wanted` [rad] (its size) and then `displacement` [m],
    in body axes as they are now: all but the last alike, in places that move evenly."""
    fewest = seen.fewest(wanted)
    if most is None:
        best = 1 + int(np.argmin((seen.times + seen.returns)[1:] / seen.headings[1:]))
        most = math.ceil(wanted / float(seen.headings[best])) + MORE
    found = [
        _of_count(seen, circle, wanted, displacement, line_time, count)
        for count in range(fewest, max(fewest, most) + 1)
    ]
    return min(found, key=lambda one: one.time)


def _of_count(
    seen: Survey,
    circle: Circle,
    wanted: float,
    displacement: complex,
    line_time: LineTime,
    count: int,
) -> Next:
    largest, before = float(seen.headings[-1]), count - 1
    each = np.full(1, wanted)
    if before:
        low = max((wanted - largest) / before, LEAST * wanted / count)
        each = np.linspace(low, min(largest, wanted / before), SIZES)
    gains = np.repeat(each[:, None], count, axis=1)
    gains[:, -1] = np.maximum(wanted - before * each, 0.0)
    swings = np.interp(gains, seen.headings, seen.swings)
    shifts = np.interp(swings, seen.swings, seen.shifts)
    spent = np.interp(swings, seen.swings, seen.times).sum(axis=1)
    headings = -circle.sense * (np.cumsum(gains, axis=1) - gains)
    final = np.exp(1j * circle.sense * wanted)  # body axes at the end, seen from those now
    if circle.extent is None:
        angles = headings + circle.sense * (np.cumsum(swings, axis=1) - swings)
        drift = (np.exp(1j * angles) * shifts).sum(axis=1)
        left = (displacement - drift * np.exp(1j * circle.starts)[:, None]) * final
        total = spent + line_time(left.ravel()).reshape(left.shape)
        where, size = divmod(int(np.argmin(total)), each.size)
        start = float(circle.starts[where])
        return Next(count, float(swings[size, 0]), start, float(total[where, size]))
    tried = []
    for first, last in itertools.product(SHARES, SHARES) if before else ((s, s) for s in SHARES):
        share = np.linspace(first, last, count)
        starts = circle.first + circle.sense * share * (circle.extent - swings)
        back = swings[:, :-1] - circle.sense * np.diff(starts, axis=1)
        returning = np.interp(np.abs(back), seen.swings, seen.returns).sum(axis=1)
        drift = (np.exp(1j * (headings + starts)) * shifts).sum(axis=1)
        total = spent + returning + line_time((displacement - drift) * final)
        k = int(np.argmin(total))
        tried.append(Next(count, float(swings[k, 0]), float(starts[k, 0]), float(total[k])))
    return min(tried, key=lambda one: one.time)


def turns(
    capsule: Capsule,
    limits: Limits,
    circle: Circle,
    drive: Drive,
    wanted: float,
    displacement: complex,
    line_time: LineTime,
) -> Iterator[Outcome]:
    """Turn manoeuvres for the heading `wanted` [rad], whose sign is opposite to the slider's, and
    then `displacement` [m], in body axes at the start. Raises ParameterError.

    After each turn has been followed the rest is scheduled anew; the last one is exact.
    """
    seen, left = survey(capsule, limits, circle, drive), abs(wanted)
    if (fewest := seen.fewest(left)) > limits.manoeuvres:
        raise too_many(limits, fewest)
    most = None
    while True:
        now = schedule(seen, circle, left, displacement, line_time, most)
        most = now.count - 1
        done = None
        if now.count > 1:
            done = outcome(
                capsule, limits.radius, now.start, circle.sense * now.swing, drive(now.swing)
            )
        if done is None or abs(done.heading) > left:
            guess, start, longest = seen.swing(left), now.start, circle.longest
            if circle.extent is not None:
                room = max(circle.extent - SPARE * guess, 0.0)
                start = circle.first + circle.sense * min(abs(start - circle.first), room)
                longest = min(longest, circle.extent - abs(start - circle.first))
            last = exact_turn(capsule, limits, circle, drive, start, longest, guess, left)
            if last is not None:
                yield last
                return
            swing = seen.swing(0.5 * left)
            done = outcome(capsule, limits.radius, now.start, circle.sense * swing, drive(swing))
        yield done
        left -= abs(done.heading)
        displacement = (displacement - done.shift) * np.exp(-1j * done.heading)
        if circle.extent is None:
            end = math.remainder(now.start + done.swing, FULL_CIRCLE)
            circle = replace(circle, starts=np.array([end]))
