"""Sliding: all three supports move, until one support or the whole body comes to rest.

Near v_i = 0 the support obeys dv/dt = alpha - c B v/|v|, with c = f N_i and B its 2 x 2 mobility.
With v = rho e the direction obeys rho d(theta)/dt = h'(theta), h = e.alpha - (c/2) e.Be. So the
direction tends to a maximum of h while rho falls to zero at a finite time. At the time s before
that, v = s (a + b s^k + ...) with an exponent k > 0 that is not an integer. There is no change of
sign to find, and no power series. In sigma (see `sliding_rates`) rho and the error of the direction
decay exponentially. Polynomials approximate such a decay well, and a few elements reduce rho to
round-off. A near miss is smooth in sigma too.

Whether the support then sticks is a separate question (`three_points.rest`). It sticks when |B^-1
alpha| <= c: then v = 0 attracts every direction, because v.B^-1 v falls. If it does not stick, h
may still have a second, lower maximum with rho falling (B must differ between its axes). An open
set of motions then meets v = 0 exactly and leaves it again at once along the other ray.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.numerics.collocation import collocate, linearised
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.three_points.equations import (
    TIME_CLOCK,
    Clock,
    ComplexForces,
    Configuration,
    Mechanics,
    sliding_rates,
    support_velocities,
)
from plumbob.analytic.systems.three_points.smooth_segment import (
    Interval,
    SegmentState,
    SmoothSegment,
    fitted_coefficients,
    monotone_root,
    speed_scale,
    state_at,
)

STUCK = 2e-14  # ratio of a support's speed to `speed_scale` below which the speed is round-off
# Ratio of a whole body's speed to its largest in this piece below which the speed is round-off
STOPPED = 1e-12
# Smallest unbalanced part of the forces as a slide starts, as a fraction of their size
UNBALANCED_FORCE = 1e-3
STEEPNESS = 0.045  # reciprocal of the power of the element's length in the truncation error
SHORTEST_ELEMENT = 1e-14  # ratio of the shortest element's length to its time scale
# lower bound on the truncation error, which bounds an element's growth
LEAST_TRUNCATION = 1e-18
# smallest and largest factor on an element that has to be shortened
SHORTENING_FACTORS = (0.2, 0.9)
FIRST_SIGMA = 2.0  # first length in sigma: e-folds of the speed that changes fastest
NEAR_POLE = 3.0  # largest distance from a zero of v_i, in time scales, for a run in sigma
# Largest ratio of the time scale to the time in which the slowest change stops a support
MAX_TIME_SCALE_RATIO = 4.0
# Smallest ratio of the speed at the end of an element to the speed that counts as stuck
END_SPEED = 0.3
MAX_SLIDE_ELEMENTS = 2000  # largest number of elements in one piece

# A function that returns approximate states, shape (n, 3). Its arguments are the times since the
# start, shape (n,), and the configuration of the slider at these times.
Guess = Callable[[Array, Configuration], Array]
Slid = tuple[list[SmoothSegment], SegmentState, tuple[int, ...]]
"""The segments of a slide, the state at its end, and the supports that are then at rest."""


@dataclass(frozen=True)
class ElementPlan:
    """How to solve the element that begins at `state`, with the slider's `terms`.

    The element's variable is time, or the sigma of `sliding_rates` with this `clock`. `longest` is
    the largest length of the element in that variable. `time_scale` [s] is the first length of an
    element in time. `slowing` [m/s^2] is the largest |dv_i/dt|. `guess` returns first slopes at the
    nodes for a given length.
    """

    interval: Interval
    state: SegmentState
    terms: Configuration
    clock: Clock
    longest: float
    time_scale: float
    slowing: float
    guess: Callable[[float], Array]

    def scale(self, change: Array) -> Array:
        """Returns the sizes of (p_x, p_y, omega, t) in an element, shape (4,), from a first guess
        of their largest `change`, shape (4,). The size of the speed is at least the speed that the
        forces would give if a part UNBALANCED_FORCE of them did not balance."""
        body = self.interval.body
        unbalanced = (
            UNBALANCED_FORCE * _unbalanced_acceleration(self.interval, self.terms) * change[3]
        )
        largest_change = float(change[:2].max())
        speed = max(speed_scale(self.terms, self.state), largest_change, unbalanced)
        turning = speed * float(np.sqrt(body.mass / self.terms.inertia[0]))
        time = self.time_scale if self.clock is TIME_CLOCK else speed / self.slowing
        return np.array([speed, speed, turning, time])

    def slopes(self, size: float, scale: Array, guess: Array) -> Array | None:
        """Returns the slopes at the nodes, shape (n, 4), of the element of length `size`, from a
        `guess`. Returns None if Newton's method does not converge."""
        body = self.interval.body
        rule = self.interval.accuracy.rule

        def right_hand_side(states: Array, with_derivatives: bool) -> tuple[Array, Array]:
            """Returns the derivatives of the states by c, and the derivatives of these by the
            states."""
            terms = self.interval.at(states[:, 3])
            rates, derivative = sliding_rates(body, terms, states, self.clock, with_derivatives)
            return size * rates, size * derivative

        with np.errstate(all="ignore"):
            start = self.state.row
            return collocate(rule, right_hand_side, start, guess, scale, all_derivatives=False)


def integrate_slide(
    interval: Interval, state: SegmentState, departure: Guess | None = None, slipped: int = -1
) -> Slid:
    """Integrates a slide from `state` until a support comes to rest or the piece ends. Returns the
    segments, the last state, and the supports at rest.

    `departure` gives first guesses of (p_x, p_y, omega) if the support `slipped` starts from rest:
    at v_i = 0 the equations define no direction, and one solution leaves it smoothly. Raises
    RuntimeError if no element is short enough.
    """
    segments: list[SmoothSegment] = []
    size = 0.0
    in_time = True
    fastest = 0.0
    duration = interval.piece.duration
    while len(segments) < MAX_SLIDE_ELEMENTS:
        terms = interval.at(state.time)
        fastest = max(fastest, speed_scale(terms, state))
        resting = () if departure is not None else resting_supports(terms, state, fastest)
        if resting or state.time >= duration:
            return segments, state, resting
        if departure is not None:
            plan = _departure_plan(interval, terms, state, departure)
        else:
            plan = _continuation_plan(interval, terms, state, fastest)
        if size == 0.0 or in_time != (plan.clock is TIME_CLOCK):
            in_time = plan.clock is TIME_CLOCK
            size = plan.time_scale if in_time else FIRST_SIGMA
        coefficients, length, size = _element(plan, min(size, plan.longest))

        last = 1.0
        end = float(coefficients[:, 3].sum())
        if in_time and length == duration - state.time:
            end = duration
        elif end > duration:
            last = float(monotone_root(coefficients[:, 3], np.array([duration]))[0])
            end = duration
        segments.append(
            SmoothSegment(
                mode="slide",
                support=slipped,
                interval=interval,
                start=state.time,
                end=end,
                coefficients=coefficients,
                last=last,
            )
        )
        state = replace(state_at(coefficients, last), time=end)
        departure, slipped = None, -1
    raise RuntimeError(f"{MAX_SLIDE_ELEMENTS} elements did not finish piece {interval.number}")


def resting_supports(
    terms: Configuration, state: SegmentState, fastest: float
) -> tuple[int, ...]:
    """Returns the supports whose speed is round-off. Returns all three if the speed of the whole
    body is round-off compared with `fastest` [m/s], the largest speed in this piece."""
    velocity = np.array([state.velocity])
    omega = np.array([state.omega])
    speeds = np.abs(support_velocities(terms, velocity, omega)[0])
    if speeds.max() <= STOPPED * fastest:
        return (0, 1, 2)
    numbers = np.flatnonzero(speeds <= STUCK * speed_scale(terms, state))
    return tuple(int(number) for number in numbers)


def _unbalanced_acceleration(interval: Interval, terms: Configuration) -> float:
    """Returns the acceleration [m/s^2] of the body if all friction forces and the slider's reaction
    acted in the same direction."""
    body = interval.body
    slider_part = body.mass_ratio * abs(complex(terms.acceleration[0]))
    return float(terms.limits[0].sum()) / body.mass + slider_part


def _departure_plan(
    interval: Interval, terms: Configuration, state: SegmentState, departure: Guess
) -> ElementPlan:
    """Returns the plan of an element in which a support starts from rest. It runs in time; `terms`
    are the slider's at the start."""
    time_scale = interval.piece.duration - state.time
    rule = interval.accuracy.rule
    if not np.isfinite(time_scale):
        time_scale = 4.0 * speed_scale(terms, state) / _unbalanced_acceleration(interval, terms)

    def guess(size: float) -> Array:
        """Returns the first slopes at the nodes of an element of length `size`."""
        elapsed = size * rule.nodes
        times = state.time + elapsed
        states = np.column_stack([departure(elapsed, interval.at(times)), times])
        return np.asarray(np.linalg.solve(rule.integral, states - state.row))

    return ElementPlan(
        interval=interval,
        state=state,
        terms=terms,
        clock=TIME_CLOCK,
        longest=time_scale,
        time_scale=time_scale,
        slowing=0.0,
        guess=guess,
    )


def _continuation_plan(
    interval: Interval, terms: Configuration, state: SegmentState, fastest: float
) -> ElementPlan:
    """Returns the plan of the element that continues a slide from `state`, with the slider's
    `terms`. `fastest` [m/s] is the largest speed scale so far in the piece."""
    body = interval.body
    start = state.row[None, :]
    omega = np.array([state.omega])
    velocities = support_velocities(terms, np.array([state.velocity]), omega)[0]
    support_accelerations = _support_accelerations(body, terms, state)
    speeds = np.abs(velocities)
    slowing = np.abs(support_accelerations)
    time_scale = interval.piece.duration - state.time
    time_scale = min(time_scale, MAX_TIME_SCALE_RATIO * float((speeds / slowing).max()))
    clock, longest = TIME_CLOCK, time_scale
    # v_i + t dv_i/dt vanishes at a complex time at the distance |v_i|/|dv_i/dt|: a pole of the
    # forces.
    if (speeds < NEAR_POLE * time_scale * slowing).any():
        clock = (1.0 / time_scale, slowing)
    rates, derivative = sliding_rates(body, terms, start, clock)
    if clock is not TIME_CLOCK:
        time_rate = float(rates[0, 3])
        decay = -time_rate * (velocities.conjugate() * support_accelerations).real / speeds**2
        longest = _longest_decay(decay, speeds, speed_scale(terms, state), fastest)

    def guess(size: float) -> Array:
        """Returns the first slopes at the nodes of an element of length `size`."""
        return size * linearised(rates[0], derivative[0], size * interval.accuracy.rule.nodes)

    return ElementPlan(
        interval=interval,
        state=state,
        terms=terms,
        clock=clock,
        longest=longest,
        time_scale=time_scale,
        slowing=float(slowing.max()),
        guess=guess,
    )


def _support_accelerations(
    body: Mechanics, terms: Configuration, state: SegmentState
) -> ComplexForces:
    """Returns dv_i/dt of the supports in body axes [m/s^2], shape (3,), while every support
    slides."""
    rates = sliding_rates(body, terms, state.row[None, :], with_derivatives=False)[0][0]
    centre_rate = complex(rates[0], rates[1])
    turning = 1j * rates[2] * terms.arms[0]
    moving_arms = 1j * state.omega * body.mass_ratio * terms.velocity[0]
    return np.asarray(centre_rate + turning - moving_arms)


def _longest_decay(decay: Array, speeds: Array, speed: float, fastest: float) -> float:
    """Returns the length in sigma, the variable of integration, over which the support that slows
    down fastest comes to rest, up to round-off. `decay` has the rates at which the logarithms of
    the `speeds` [m/s] fall, per unit of sigma. The end speed is a small fraction of the scale
    `speed` or of the `fastest` speed of the motion, whichever is larger."""
    first = int(np.argmax(decay))
    if not decay[first] > 0.0:
        return float(np.inf)
    stopped = STOPPED * fastest * float(speeds[first] / speeds.max())
    end_speed = END_SPEED * max(STUCK * speed, stopped)
    return float(np.log(speeds[first] / end_speed) / decay[first])


def _element(plan: ElementPlan, size: float) -> tuple[Array, float, float]:
    """Returns the coefficients of the element, its length in its variable, and a length for the
    next element. The element is `size` long, or shorter if its truncation error would exceed the
    tolerance. Raises RuntimeError if no length is short enough."""
    rule = plan.interval.accuracy.rule
    tolerance = plan.interval.accuracy.tolerance
    smallest = SHORTEST_ELEMENT * (plan.time_scale if plan.clock is TIME_CLOCK else 1.0)
    guess = plan.guess(size)
    while size >= smallest:
        scale = plan.scale(np.abs(rule.integral @ guess).max(axis=0))
        slopes = plan.slopes(size, scale, guess)
        truncation = np.inf if slopes is None else rule.truncation(slopes, scale)
        growth = 0.9 * (tolerance / max(truncation, LEAST_TRUNCATION)) ** STEEPNESS
        if slopes is not None and truncation <= tolerance:
            coefficients = fitted_coefficients(plan.interval, plan.state, slopes)
            return coefficients, size, size * growth
        factor = min(SHORTENING_FACTORS[1], max(SHORTENING_FACTORS[0], growth))
        size *= factor
        guess = plan.guess(size) if slopes is None else rule.shortened(slopes, factor)
    raise RuntimeError(f"no step is small enough at {plan.state.time!r} s of a piece")
