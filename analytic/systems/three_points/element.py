"""One collocation element of a slide: the variable it runs in, its longest size, its solution."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.slider_path import Piece
from plumbob.analytic.systems.three_points.collocation import Scheme, collocate, linearised, tail
from plumbob.analytic.systems.three_points.equations import (
    Configuration,
    Mechanics,
    configuration,
    sliding_rates,
    support_velocities,
)
from plumbob.analytic.systems.three_points.smooth_segment import State, fitted, speed_scale

STUCK = 2e-14  # a support's speed over speed_scale: what is left is round-off
STOPPED = 1e-12  # the same for the whole body, over its speed in this piece
SHORT = 1e-7  # element over the time itself, below which w is as good as constant
ROUGH = 1e-3  # speed gained by the least unbalanced start, over what its balanced forces would give
STEEPNESS = 0.045  # one over the power of an element's size that it leaves out
SMALLEST = 1e-14  # element over the time scale
FIRST = 2.0  # length in sigma: e-folds of the speed that changes fastest

Guess = Callable[[Array, Configuration], Array]  # times since the start, slider -> states (n, 3)


@dataclass(frozen=True)
class Accuracy:
    """Discretisation: the collocation rule, and what an element may leave out, relatively."""

    rule: Scheme
    tolerance: float


@dataclass(frozen=True)
class Course:
    """How the next element is to go: its `clock` (None: it runs in time; see sliding_rates), the
    longest it may be, a time scale [s], the sizes of speeds [m/s], 1/lengths [1/m] and times [s] in
    its state, and first slopes at the nodes for a length."""

    clock: tuple[float, Array] | None
    longest: float
    horizon: float
    local: float
    jolt: float
    lever: float
    brisk: float
    guess: Callable[[float], Array]


@dataclass(frozen=True)
class Element:
    """A solved element: SmoothSegment coefficients, its length in its variable, and the next one's."""

    coefficients: Array
    size: float
    next_size: float


def support_speeds(at: Configuration, state: State) -> Array:
    """|v_i| [m/s], shape (3,)."""
    point, omega = np.array([state.point]), np.array([state.omega])
    return np.asarray(np.abs(support_velocities(at, point, omega)[0]))


def _row(state: State) -> Array:
    return np.array([state.point.real, state.point.imag, state.omega, state.time])


def _lasting(body: Mechanics, at: Configuration, state: State) -> tuple[float, float]:
    """Speed scale [m/s] and the acceleration that forces give where they do not balance [m/s^2]."""
    push = body.mass_ratio * abs(complex(at.acceleration[0]))
    jolt = float(at.limits[0].sum()) / body.mass + push + abs(body.tilt)
    return speed_scale(at, state), jolt


def departing(
    body: Mechanics, piece: Piece, rule: Scheme, state: State, remaining: float, departure: Guess
) -> Course:
    """The element in which a support leaves its rest, in time; `remaining` [s] of the piece."""
    at = configuration(body, piece, np.array([state.time]))
    local, jolt = _lasting(body, at, state)
    horizon = remaining if np.isfinite(remaining) else 4.0 * local / jolt

    def guess(size: float) -> Array:
        times = size * rule.nodes
        later = configuration(body, piece, state.time + times)
        states = np.column_stack([departure(times, later), state.time + times])
        return np.asarray(np.linalg.solve(rule.integrals, states - _row(state)))

    lever = float(np.sqrt(body.mass / at.inertia[0]))
    return Course(None, horizon, horizon, local, jolt, lever, 0.0, guess)


def course(
    body: Mechanics, piece: Piece, rule: Scheme, state: State, remaining: float, fastest: float
) -> Course:
    """The element that goes on sliding from `state`; `remaining` [s] of the piece, `fastest` [m/s]
    the largest speed scale met in it."""
    at = configuration(body, piece, np.array([state.time]))
    local, jolt = _lasting(body, at, state)
    lever = float(np.sqrt(body.mass / at.inertia[0]))
    start, heading = _row(state)[None, :], np.array([state.heading])
    velocities = support_velocities(at, np.array([state.point]), start[:, 2])[0]
    speeds = np.abs(velocities)
    rates, derivative = sliding_rates(body, at, start, heading, None)
    sweeping = 1j * state.omega * body.mass_ratio * at.velocity[0]
    changes = complex(rates[0, 0], rates[0, 1]) + 1j * rates[0, 2] * at.arms[0] - sweeping
    brisk = np.abs(changes)
    horizon = min(remaining, 4.0 * float((speeds / brisk).max()))
    clock, longest = None, min(horizon, remaining)
    # v_i + t dv_i/dt vanishes at a complex time, |v_i|/|dv_i/dt| from here: a pole of the forces.
    if (speeds < 3.0 * horizon * brisk).any():
        clock, longest = (1.0 / horizon, brisk), np.inf
        rates, derivative = sliding_rates(body, at, start, heading, clock)
        decay = -float(rates[0, 3]) * (velocities.conjugate() * changes).real / speeds**2
        first = int(np.argmax(decay))
        floor = 0.3 * max(STUCK * local, STOPPED * fastest * float(speeds[first] / speeds.max()))
        if decay[first] > 0.0:
            longest = float(np.log(speeds[first] / floor) / decay[first])

    def guess(size: float) -> Array:
        return size * linearised(rates[0], derivative[0], size * rule.nodes)

    return Course(clock, longest, horizon, local, jolt, lever, float(brisk.max()), guess)


def _solution(
    body: Mechanics, piece: Piece, rule: Scheme, state: State, plan: Course, size: float
) -> tuple[Array, float] | None:
    """Slopes at the nodes, and what is left out over the size of the state."""
    heading = np.full(rule.nodes.size, state.heading)

    def right_hand_side(states: Array) -> tuple[Array, Array]:
        at = configuration(body, piece, states[:, 3])
        jerk = None
        if plan.clock and at.acceleration.any():
            passing = rule.slopes @ states[:, 3]
            if passing.min() > SHORT * abs(states[-1, 3]):
                jerk = (rule.slopes @ at.acceleration) / passing
        rates, derivative = sliding_rates(body, at, states, heading, plan.clock, jerk)
        if body.tilt:
            heading[:] = state.heading + size * rule.integrals @ (states[:, 2] * rates[:, 3])
        return size * rates, size * derivative

    guess = plan.guess(size)
    ahead = np.abs(rule.integrals @ guess).max(axis=0)
    spread = max(plan.local, float(ahead[:2].max()), ROUGH * plan.jolt * float(ahead[3]))
    lasting = spread / plan.brisk if plan.clock else plan.horizon
    scale = np.array([spread, spread, spread * plan.lever, lasting])
    with np.errstate(all="ignore"):
        slopes = collocate(rule, right_hand_side, _row(state), guess, scale)
    return None if slopes is None else (slopes, tail(rule, slopes, scale))


def element(
    body: Mechanics, piece: Piece, accuracy: Accuracy, state: State, plan: Course, size: float
) -> Element:
    """The element from `state` with a length of at most `size`, shortened until it leaves out no
    more than the tolerance. Raises RuntimeError when none is short enough."""
    rule, least = accuracy.rule, SMALLEST * (1.0 if plan.clock else plan.horizon)
    while size >= least:
        found = _solution(body, piece, rule, state, plan, size)
        left_out = np.inf if found is None else max(found[1], 1e-18)
        change = 0.9 * (accuracy.tolerance / left_out) ** STEEPNESS
        if found is not None and left_out <= accuracy.tolerance:
            coefficients = fitted(rule, body, piece, state, found[0])
            return Element(coefficients, size, size * change)
        size *= min(0.9, max(0.2, change))
    raise RuntimeError(f"no step is small enough at {state.time!r} s of a piece")
