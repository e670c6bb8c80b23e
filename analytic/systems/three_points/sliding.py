"""Sliding: all three supports move, until one of them, or the whole body, comes to rest.

Near v_i = 0 the support obeys dv/dt = alpha - c B v/|v|, with c = f N_i and B its 2 x 2 mobility.
With v = rho e the direction obeys rho d(theta)/dt = h'(theta), h = e.alpha - (c/2) e.Be, so it
settles on a maximum of h while rho falls to zero at a finite time, s later: v = s (a + b s^k + ...)
with an exponent k > 0 that is no integer. There is no change of sign to find, and no power series.
In sigma (see sliding_rates) rho and the direction's error decay as exponentials, which polynomials
follow, and a few elements bring rho down to round-off; a near miss is smooth in sigma as well.

Whether the support then stays is a question of its own (`three_points.rest`): it does when
|B^-1 alpha| <= c, and then it attracts from every direction, for v.B^-1 v falls. When it does not,
h may still have a second, lower maximum with rho falling (B must differ between its axes): an open
set of motions meets v = 0 exactly and leaves it again at once along the other ray.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.systems.slider_path import Piece
from plumbob.analytic.systems.three_points.element import (
    FIRST,
    STOPPED,
    STUCK,
    Accuracy,
    Guess,
    course,
    departing,
    element,
    support_speeds,
)
from plumbob.analytic.systems.three_points.equations import Mechanics, configuration
from plumbob.analytic.systems.three_points.smooth_segment import (
    SmoothSegment,
    State,
    monotone_root,
    speed_scale,
    state_at,
)

ELEMENTS = 2000  # in one piece, before giving up


@dataclass(frozen=True)
class Slid:
    """What a slide came to: its segments, the state at its end, and the supports then at rest."""

    segments: list[SmoothSegment]
    state: State
    still: tuple[int, ...]


def slide(
    body: Mechanics,
    piece: Piece,
    number: int,
    duration: float,
    state: State,
    accuracy: Accuracy,
    departure: Guess | None = None,
    slipped: int = -1,
) -> Slid:
    """Slide from `state` until a support comes to rest or `duration` [s] of piece `number` is over.

    `departure` gives first guesses of (p_x, p_y, omega) where a support starts from rest: the
    equations say nothing of a direction at v_i = 0, and one solution leaves it smoothly. `slipped`
    is the support that does. Raises RuntimeError when no element is small enough.
    """
    segments: list[SmoothSegment] = []
    size, timed, fastest = 0.0, True, 0.0
    while len(segments) < ELEMENTS:
        remaining = duration - state.time
        at = configuration(body, piece, np.array([state.time]))
        speeds, local = support_speeds(at, state), speed_scale(at, state)
        fastest = max(fastest, local)
        if departure is None:
            if speeds.max() <= STOPPED * fastest:
                return Slid(segments, state, (0, 1, 2))
            stuck = np.flatnonzero(speeds <= STUCK * local)
            if stuck.size:
                return Slid(segments, state, tuple(int(i) for i in stuck))
        if remaining <= 0.0:
            return Slid(segments, state, ())

        if departure is not None:
            plan = departing(body, piece, accuracy.rule, state, remaining, departure)
        else:
            plan = course(body, piece, accuracy.rule, state, remaining, fastest)
        if size == 0.0 or timed != (plan.clock is None):
            size, timed = (FIRST if plan.clock else plan.horizon), plan.clock is None
        found = element(body, piece, accuracy, state, plan, min(size, plan.longest))

        last, end = 1.0, float(found.coefficients[:, 3].sum())
        if timed and found.size == remaining:
            end = duration
        elif end > duration:
            last = float(monotone_root(found.coefficients[:, 3], np.array([duration]))[0])
            end = duration
        segments.append(
            SmoothSegment(
                "slide", slipped, number, state.time, end, state, found.coefficients, last
            )
        )
        state = replace(state_at(found.coefficients, last), time=end)
        size, departure, slipped = found.next_size, None, -1
    raise RuntimeError(f"{ELEMENTS} elements did not finish piece {number}")
