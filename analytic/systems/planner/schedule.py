"""Which turns to make: sizes and places for least total time, the last one closing the heading.

Every turn shifts C as well, by centimetres, and lines have to make up the rest: so the time of the
lines counts in the choice of the turns. On a free plane the slider continues round the circle and
the shifts cancel; on an arc its returns cost time, and the place of a turn on the arc decides in
which direction C moves.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

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

SIZES = 33  # sizes tried for the turns before the last, for each number of turns
MORE = 12  # turns tried beyond the number for the quickest rotation alone
LEAST = 0.2  # of an equal part of the heading, for the turns before the last
SPARE = 1.05  # times the arc that the last turn is estimated to need
BEFORE = (0.0, 0.5, 1.0)  # fractions of the arc left by a turn, tried as the part before it

TIE = 1e-10  # of a time: choices this near are equal, as with one more turn that has no size

Kind = TypeVar("Kind")
LineTime = Callable[[Complex], Array]
"""Displacements of the body in its axes [m], shape (n,) -> estimated time of the lines [s]."""


@dataclass(frozen=True)
class Next:
    """The turn to make now, the first of the `count` remaining: slider's angle `swing` from `start`
    [rad], and the estimated time of everything that remains [s]."""

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
    in present body axes: all but the last turn are equal, and their places change evenly."""
    fewest = seen.fewest(wanted)
    if most is None:
        best = 1 + int(np.argmin((seen.times + seen.returns)[1:] / seen.headings[1:]))
        most = math.ceil(wanted / float(seen.headings[best])) + MORE
    found = [
        _of_count(seen, circle, wanted, displacement, line_time, count)
        for count in range(fewest, max(fewest, most) + 1)
    ]
    return first_of_least(found, lambda one: one.time)


def first_of_least(found: Iterable[Kind], time: Callable[[Kind], float]) -> Kind:
    """The first whose `time` [s] is the least, to rounding."""
    times = [(time(one), one) for one in found]
    least = min(one[0] for one in times)
    return next(one for taken, one in times if taken <= least * (1.0 + TIE))


def _of_count(
    seen: Survey,
    circle: Circle,
    wanted: float,
    displacement: complex,
    line_time: LineTime,
    count: int,
) -> Next:
    """The best start with `count` turns."""
    sizes = _Sizes.of(seen, circle, wanted, count)
    if circle.extent is None:
        return _on_circle(sizes, circle, displacement, line_time)
    tried = itertools.product(BEFORE, BEFORE) if count > 1 else ((s, s) for s in BEFORE)
    found = [_on_arc(seen, sizes, circle, displacement, line_time, *ends) for ends in tried]
    return first_of_least(found, lambda one: one.time)


@dataclass(frozen=True)
class _Sizes:
    """`count` turns in n sizes of those before the last.

    `swings` [rad], `shifts` of C [m] and the body's `headings` [rad] before each turn, shape (n,
    count); their time `spent` [s], shape (n,); `final` turns body axes now into those at the end.
    """

    count: int
    swings: Array
    shifts: Complex
    headings: Array
    spent: Array
    final: complex

    @classmethod
    def of(cls, seen: Survey, circle: Circle, wanted: float, count: int) -> _Sizes:
        """All turns but the last of one size, the last one for the rest of `wanted` [rad]."""
        largest, before = float(seen.headings[-1]), count - 1
        each = np.full(1, wanted)
        if before:
            low = max((wanted - largest) / before, LEAST * wanted / count)
            each = np.linspace(low, min(largest, wanted / before), SIZES)
        gains = np.repeat(each[:, None], count, axis=1)
        gains[:, -1] = np.maximum(wanted - before * each, 0.0)
        swings = np.interp(gains, seen.headings, seen.swings)
        return cls(
            count=count,
            swings=swings,
            shifts=np.interp(swings, seen.swings, seen.shifts),
            headings=-circle.sense * (np.cumsum(gains, axis=1) - gains),
            spent=np.interp(swings, seen.swings, seen.times).sum(axis=1),
            final=np.exp(1j * circle.sense * wanted),
        )


def _on_circle(sizes: _Sizes, circle: Circle, displacement: complex, line_time: LineTime) -> Next:
    """The best size and start where the slider continues round the circle."""
    turned = circle.sense * (np.cumsum(sizes.swings, axis=1) - sizes.swings)
    drift = (np.exp(1j * (sizes.headings + turned)) * sizes.shifts).sum(axis=1)
    left = (displacement - drift * np.exp(1j * circle.starts)[:, None]) * sizes.final
    total = sizes.spent + line_time(left.ravel()).reshape(left.shape)
    where, size = divmod(int(np.argmin(total)), sizes.spent.size)
    return Next(
        sizes.count,
        float(sizes.swings[size, 0]),
        float(circle.starts[where]),
        float(total[where, size]),
    )


def _on_arc(
    seen: Survey,
    sizes: _Sizes,
    circle: Circle,
    displacement: complex,
    line_time: LineTime,
    first: float,
    last: float,
) -> Next:
    """The best size where the slider returns after each turn. The part of the arc before a turn, as
    a fraction of what the turn leaves, changes evenly from `first` to `last`."""
    assert circle.extent is not None
    before = np.linspace(first, last, sizes.count)
    starts = circle.first + circle.sense * before * (circle.extent - sizes.swings)
    back = sizes.swings[:, :-1] - circle.sense * np.diff(starts, axis=1)
    returning = np.interp(np.abs(back), seen.swings, seen.returns).sum(axis=1)
    drift = (np.exp(1j * (sizes.headings + starts)) * sizes.shifts).sum(axis=1)
    total = sizes.spent + returning + line_time((displacement - drift) * sizes.final)
    k = int(np.argmin(total))
    return Next(sizes.count, float(sizes.swings[k, 0]), float(starts[k, 0]), float(total[k]))


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

    After each turn has been computed the rest is scheduled anew; the last one is exact. One may
    turn the body the other way: what a turn with a heavy slider near C does depends on where it
    begins more than on its size.
    """
    seen, left = survey(capsule, limits, circle, drive), abs(wanted)
    most = None
    for made in itertools.count():
        if (least := made + seen.fewest(left)) > limits.manoeuvres:
            raise too_many(limits, least)
        now = schedule(seen, circle, left, displacement, line_time, most)
        most = now.count - 1
        done = None
        if now.count > 1:
            done = outcome(
                capsule, limits.radius, now.start, circle.sense * now.swing, drive(now.swing)
            )
        if done is None or circle.gained(done.heading) > left:
            guess, start, longest = seen.swing(left), now.start, circle.longest
            if circle.extent is not None:
                margin = max(circle.extent - SPARE * guess, 0.0)
                start = circle.first + circle.sense * min(abs(start - circle.first), margin)
                longest = min(longest, circle.extent - abs(start - circle.first))
            last = exact_turn(capsule, limits, circle, drive, start, longest, guess, left)
            if last is not None:
                yield last
                return
            swing = seen.swing(0.5 * left)
            done = outcome(capsule, limits.radius, now.start, circle.sense * swing, drive(swing))
        yield done
        left -= circle.gained(done.heading)
        displacement = (displacement - done.shift) * np.exp(-1j * done.heading)
        if circle.extent is None:
            end = math.remainder(now.start + done.swing, FULL_CIRCLE)
            circle = replace(circle, starts=np.array([end]))
