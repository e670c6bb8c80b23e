"""Sliding: all three supports move, until one of them, or the whole body, comes to rest.

Near v_i = 0 the support obeys dv/dt = alpha - c B v/|v|, with c = f N_i and B its 2 x 2 mobility.
With v = rho e the direction obeys rho d(theta)/dt = h'(theta), h = e.alpha - (c/2) e.Be, so it
settles on a maximum of h while rho falls to zero at a finite time, s later: v = s (a + b s^k + ...)
with an exponent k > 0 that is no integer. There is no change of sign to find, and no power series.
In sigma (see sliding_rates) rho and the direction's error decay as exponentials, which polynomials
follow, and a few elements bring rho down to round-off; a near miss is smooth in sigma as well.

Whether the support then stays is a question of its own (`analytic.three_point_rest`): it does when
|B^-1 alpha| <= c, and then it attracts from every direction, for v.B^-1 v falls. When it does not,
h may still have a second, lower maximum with rho falling (B must differ between its axes): an open
set of motions meets v = 0 exactly and leaves it again at once along the other ray.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from analytic.reference import Array
from analytic.slider_path import Piece
from analytic.three_point_collocation import Scheme, collocate, linearised, tail
from analytic.three_point_equations import (
    Configuration,
    Mechanics,
    configuration,
    sliding_rates,
    support_velocities,
)
from analytic.three_point_stretch import (
    State,
    Stretch,
    fitted,
    monotone_root,
    speed_scale,
    state_at,
)

STUCK = 2e-14  # a support's speed over speed_scale: what is left is round-off
STOPPED = 1e-12  # the same for the whole body, over its speed in this piece
SHORT = 1e-7  # element over the time itself, below which w is as good as constant
ROUGH = 1e-3  # speed gained by the least unbalanced start, over what its balanced forces would give
STEEPNESS = 0.045  # one over the power of an element's size that it leaves out
SMALLEST = 1e-14  # element over the piece's time scale
ELEMENTS = 2000  # in one piece, before giving up

Guess = Callable[[Array, Configuration], Array]  # times since the start, slider -> states (n, 3)


@dataclass(frozen=True)
class Accuracy:
    """Discretisation: the collocation rule, and what an element may leave out, relatively."""

    rule: Scheme
    tolerance: float


@dataclass(frozen=True)
class Slid:
    """What a slide came to: its stretches, the state at its end, and the supports then at rest."""

    stretches: list[Stretch]
    state: State
    still: tuple[int, ...]


@dataclass(frozen=True)
class _Element:
    slopes: Array
    coefficients: Array
    left_out: float


def _element(
    body: Mechanics,
    piece: Piece,
    rule: Scheme,
    state: State,
    clock: tuple[float, Array] | None,
    guess: Array,
    scale: Array,
    size: float,
) -> _Element | None:
    heading = np.full(rule.nodes.size, state.heading)

    def right_hand_side(states: Array) -> tuple[Array, Array]:
        at = configuration(body, piece, states[:, 3])
        jerk = None
        if clock and at.acceleration.any():
            passing = rule.slopes @ states[:, 3]
            if passing.min() > SHORT * abs(states[-1, 3]):
                jerk = (rule.slopes @ at.acceleration) / passing
        rates, derivative = sliding_rates(body, at, states, heading, clock, jerk)
        if body.tilt:
            heading[:] = state.heading + size * rule.integrals @ (states[:, 2] * rates[:, 3])
        return size * rates, size * derivative

    start = np.array([state.point.real, state.point.imag, state.omega, state.time])
    with np.errstate(all="ignore"):
        slopes = collocate(rule, right_hand_side, start, guess, scale)
    if slopes is None:
        return None
    return _Element(slopes, fitted(rule, body, piece, state, slopes), tail(rule, slopes, scale))


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
    rule = accuracy.rule
    stretches: list[Stretch] = []
    size, timed, fastest = 0.0, True, 0.0
    while len(stretches) < ELEMENTS:
        remaining = duration - state.time
        at = configuration(body, piece, np.array([state.time]))
        start = np.array([[state.point.real, state.point.imag, state.omega, state.time]])
        velocities = support_velocities(at, np.array([state.point]), start[:, 2])[0]
        speeds = np.abs(velocities)
        local = speed_scale(at, state)
        fastest = max(fastest, local)
        if departure is None:
            if speeds.max() <= STOPPED * fastest:
                return Slid(stretches, state, (0, 1, 2))
            stuck = np.flatnonzero(speeds <= STUCK * local)
            if stuck.size:
                return Slid(stretches, state, tuple(int(i) for i in stuck))
        if remaining <= 0.0:
            return Slid(stretches, state, ())

        clock: tuple[float, Array] | None = None
        push = complex(at.acceleration[0]) * body.mass_ratio
        jolt = float((at.limits[0] / body.mass).sum()) + abs(push) + abs(body.tilt)
        horizon = remaining
        if not np.isfinite(remaining):
            horizon = 4.0 * local / jolt
        if departure is None:
            heading = np.array([state.heading])
            rates, derivative = sliding_rates(body, at, start, heading, None)
            sweeping = 1j * state.omega * body.mass_ratio * at.velocity[0]
            changes = complex(rates[0, 0], rates[0, 1]) + 1j * rates[0, 2] * at.arms[0] - sweeping
            brisk = np.abs(changes)
            horizon = min(horizon, 4.0 * float((speeds / brisk).max()))
            # A pole at the complex time where v_i + t dv_i/dt vanishes, |v_i|/|dv_i/dt| from here.
            if (speeds < 3.0 * horizon * brisk).any():
                clock = (1.0 / horizon, brisk)
                rates, derivative = sliding_rates(body, at, start, heading, clock)
        if (clock is None) != timed or size == 0.0:
            size, timed = (horizon if clock is None else 2.0), clock is None
        if clock is None:
            size = min(size, remaining)
        else:
            closing = -(velocities.conjugate() * changes).real / speeds
            decay = float(rates[0, 3]) * closing / speeds
            first = int(np.argmax(decay))
            floor = 0.3 * max(STUCK * local, STOPPED * fastest * speeds[first] / speeds.max())
            if decay[first] > 0.0:
                size = min(size, np.log(speeds[first] / floor) / decay[first])

        while True:
            times = size * rule.nodes
            if departure is not None:
                later = configuration(body, piece, state.time + times)
                states = np.column_stack([departure(times, later), state.time + times])
                guess = np.linalg.solve(rule.integrals, states - start)
            else:
                guess = size * linearised(rates[0], derivative[0], times)
            ahead = np.abs(rule.integrals @ guess).max(axis=0)
            spread = max(local, float(ahead[:2].max()), ROUGH * jolt * float(ahead[3]))
            gyration = float(np.sqrt(at.inertia[0] / body.mass))
            lasting = spread / float(brisk.max()) if clock else horizon
            scale = np.array([spread, spread, spread / gyration, lasting])
            element = _element(body, piece, rule, state, clock, guess, scale, size)
            if element is not None and element.left_out <= accuracy.tolerance:
                break
            left_out = np.inf if element is None else element.left_out
            size *= min(0.9, max(0.2, 0.9 * (accuracy.tolerance / left_out) ** STEEPNESS))
            if size < SMALLEST * (horizon if clock is None else 1.0):
                raise RuntimeError(f"no step is small enough at {state.time!r} s of piece {number}")

        last, end = 1.0, float(element.coefficients[:, 3].sum())
        if clock is None and size == remaining:
            end = duration
        elif end > duration:
            last = float(monotone_root(element.coefficients[:, 3], np.array([duration]))[0])
            end = duration
        stretches.append(
            Stretch("slide", slipped, number, state.time, end, state, element.coefficients, last)
        )
        reached = state_at(element.coefficients, last)
        state = replace(reached, time=end)
        size *= max(0.5, 0.9 * (accuracy.tolerance / max(element.left_out, 1e-18)) ** STEEPNESS)
        departure, slipped = None, -1
    raise RuntimeError(f"{ELEMENTS} elements did not finish piece {number}")
