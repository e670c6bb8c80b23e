"""A certified reference of any smooth system: two independent integrations of high order.

The first is Gauss collocation, whose polynomials are resolved to round-off, so that they give the
motion at any time. The second is an explicit method of order 8 in many small steps. It runs over
all steps of the first at once: each run starts at the beginning of one step and ends at the
beginning of the next, where it differs a little from the first method. These differences,
propagated by the motion's own linearisation, add up to the difference of the two motions (parallel
shooting: Bellen and Zennaro 1989, J. Comput. Appl. Math. 25, 341). The same run carries the
derivatives by the start and by the parameters, as imaginary parts.

Both methods round. Rounding errors of different steps are independent, so that the two motions may
agree by chance although neither is exact. The variance of their difference does not cancel: it is
the sum of the squares of the propagated differences of all steps.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.collocation import (
    RightHandSide,
    TimeGrid,
    collocate,
    gauss_collocation,
)
from plumbob.analytic.numerics.linear_flow import Response
from plumbob.analytic.numerics.smooth.smooth_system import IMAGINARY_STEP, SmoothSystem
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Signals, remembered
from plumbob.analytic.tableau import order_8

CERTIFIED_STAGES = 20  # stages of the collocation
STEPS_BETWEEN_CHECKS = 32  # steps of the first method that the second method checks in one call
SECOND_METHOD_STEPS = 24  # steps of the second method in one step of the first
# Largest relative size of a resolved step's last Legendre coefficients; a tenth is round-off.
RESOLVED_COEFFICIENT = 1e-15
# coefficients from this degree on decide whether a step may double
FIRST_HIGH_DEGREE = 2 * CERTIFIED_STAGES // 3
MAX_STEP_TIME_CONSTANTS = 4.0  # longest step, in time constants of the fastest deviation
SMALLEST_STEP_RATIO = 2.0**-24  # ratio of the smallest step to the first step
SIGMAS = 3.0  # standard deviations of the random walk that the steps' differences make
CERTIFIED_UNCERTAINTY = 1e-3  # largest relative uncertainty of a certified motion


@dataclass(frozen=True)
class _Track:
    """A motion up to the time that has been integrated; d numbers of state, c inputs."""

    step: float  # [s] length of the next step
    solution: Response | None  # solution of the first method; None before the first step
    end: Array  # last state of the first method, shape (d,)
    # Derivatives of the last state by each input, and in the last column the difference of the two
    # methods, shape (d, c + 1).
    response: Array
    variance: Array  # covariance of the last state by rounding in all steps, shape (d, d)
    size: Array  # largest magnitudes so far, shape (d,)
    difference: Array  # largest difference of the two methods so far, shape (d,)
    times: Array  # [s] times at which the uncertainty is known, shape (m,)
    doubts: Array  # uncertainty at these times, shape (m, d)
    until: float = math.inf  # [s] end of the certified motion
    why: str = ""  # reason why the motion is not certified further

    @property
    def reached(self) -> float:
        """Time that the first method has reached [s]."""
        return 0.0 if self.solution is None else self.solution.orbit.duration


@dataclass(frozen=True, eq=False)
class CertifiedMotion:
    """The motion of a `system`; a `Reference`.

    The motion is integrated up to the latest time that has been requested, and stored. Raises
    ParameterError for times at which double precision no longer determines the motion.
    """

    system: SmoothSystem
    _known: list[_Track] = field(default_factory=list, repr=False)

    @remembered
    def observe(self, times: Array) -> Signals:
        """Returns the observables at `times` [s], shape (n,), by name."""
        return self.system.observed(self._track(times)[1].T)

    def uncertainty(self, times: Array) -> Signals:
        """Returns the uncertainty of each observable at `times` [s], shape (n,).

        It is a sum: the largest difference between the two methods up to that time, SIGMAS standard
        deviations of that difference, the error of the first method's polynomials, and the effect
        of rounded inputs. Between two stored times the larger of both values holds."""
        track, states = self._track(times)
        after = np.searchsorted(track.times, times, side="right")
        before = track.doubts[after - 1]
        last = len(track.doubts) - 1
        doubts = np.maximum(before, track.doubts[np.minimum(after, last)])
        return self.system.doubts(states.T, doubts.T)

    def _track(self, times: Array) -> tuple[_Track, Array]:
        """Returns the track up to the last of `times` [s], and the states at `times`, shape
        (n, d)."""
        track = self._track_until(times)
        assert track.solution is not None
        return track, track.solution.at(np.asarray(times))

    def certify(self, last: float, watch: Callable[[float], None]) -> None:
        """Integrates the motion up to `last` [s] and stores it, or up to the time beyond which its
        error has no bound, for a reason that is stored too.

        `watch` is called before every step with the time [s] up to which the motion is certified.
        If `watch` raises, the motion up to that time is stored, with the same bits as in a longer
        integration.
        """
        with np.errstate(all="ignore"):  # a motion that overflows ends: numpy need not warn
            track = self._known[0] if self._known else _first_track(self.system)
            while not track.why and (track.solution is None or track.reached < last):
                track = _extended_track(self.system, track, watch)
                self._known[:] = [track]

    def known_until(self, last: float) -> float:
        """Returns the time [s] up to which the motion is certified, at most `last` [s]."""
        try:
            self._track_until(np.array([last]))
        except ParameterError:
            return self._known[0].until
        return last

    def nonlinearity(self, times: Array, errors: Signals) -> float:
        """Returns the nonlinear response of the rates to `errors` of the state over their linear
        response, at `times` [s], shape (n,)."""
        states = self.system.state(self.observe(times))
        zeros = np.zeros(len(times))
        state_errors = self.system.state(defaultdict(lambda: zeros, errors))
        linear = np.einsum("ijn,jn->in", self.system.jacobian(times, states), state_errors)
        rates = self.system.slope(times, states)
        remainder = self.system.slope(times, states + state_errors) - rates - linear
        largest = float(np.abs(linear).max())
        return float(np.abs(remainder).max()) / largest if largest else 0.0

    def _track_until(self, times: Array) -> _Track:
        """Returns the track up to the last of `times` [s] or beyond. Raises ParameterError if the
        motion is not certified that far."""
        last = float(np.max(times, initial=0.0))
        self.certify(last, lambda reached: None)
        track = self._known[0]
        if last > track.until or track.solution is None:
            raise ParameterError("times", last, f"at most {track.until:.4g} s: {track.why}")
        return track


def _first_track(system: SmoothSystem) -> _Track:
    """Returns the track of a system at time 0."""
    start = system.start
    size = len(start)
    inputs = size + len(system.parameters)
    rate = _fastest_rate(system, 0.0, start)
    step = 2.0 ** math.floor(-math.log2(rate)) if 0.0 < rate < math.inf else 1.0
    return _Track(
        step=step,
        solution=None,
        end=start,
        response=np.eye(size, inputs + 1),
        variance=np.zeros((size, size)),
        size=np.abs(start),
        difference=np.zeros(size),
        times=np.empty(0),
        doubts=np.empty((0, size)),
    )


def _fastest_rate(system: SmoothSystem, time: float, state: Array) -> float:
    """Returns the largest rate [1/s] at which small deviations change; infinite if the Jacobian is
    not finite."""
    jacobian = system.jacobian(time, state[:, None])[..., 0]
    if not np.isfinite(jacobian).all():
        return math.inf
    return float(np.abs(np.linalg.eigvals(jacobian)).max())


def _extended_track(
    system: SmoothSystem, track: _Track, watch: Callable[[float], None]
) -> _Track:
    """Returns a track extended by up to STEPS_BETWEEN_CHECKS steps of collocation.

    A second, independent integration gives the uncertainty at each new time. `watch` is called
    before each step, see `certify`.
    """
    block, step, why = _next_block(system, track, watch)
    if block is None:
        return replace(track, until=min(track.until, track.reached), why=why)
    shots = _second_integration(system, block)
    times, states = _second_states(block, shots)
    responses, response = _propagated_responses(track.response, block, shots)
    spread, variance = _rounding_spread(track.variance, block, shots)
    size = np.maximum(track.size, np.abs(states).max(axis=0))
    differences = np.concatenate([track.difference[None], np.abs(responses[..., -1])])
    differences = np.maximum.accumulate(differences)[1:]
    doubts = differences + spread + ULP * _condition(system, times, states, responses, size)
    uncertain = ~np.all(doubts <= CERTIFIED_UNCERTAINTY * _scales(size, _rate(block)), axis=1)
    until = block.orbit.duration if why else track.until
    if uncertain.any():
        until = float(times[uncertain.argmax()])
        why = "double precision determines it no further"
    return _Track(
        step=step,
        solution=block if track.solution is None else track.solution.followed_by(block),
        end=block.states[-1],
        response=response,
        variance=variance,
        size=size,
        difference=differences[-1],
        times=np.concatenate([track.times, times]),
        doubts=np.concatenate([track.doubts, doubts]),
        until=until,
        why=why,
    )


def _condition(
    system: SmoothSystem, times: Array, states: Array, responses: Array, size: Array
) -> Array:
    """Returns the change of the states, shape (m, d), by one unit in the last place of every input
    and of the times, in units of ULP.

    `responses` has the derivatives by the inputs, shape (m, d, inputs + 1). `size` has the largest
    magnitudes of the state so far, shape (d,).
    """
    inputs = np.append(size, np.ones(len(system.parameters)))
    by_inputs = np.abs(states) + np.abs(responses[..., :-1]) @ inputs
    by_times = np.abs(times * system.slope(times, states.T)).T
    return np.asarray(by_inputs + by_times)


def _rate(block: Response) -> float:
    """Returns the inverse of the longest step [1/s]."""
    return float(1.0 / np.diff(block.orbit.breakpoints).max())


def _second_states(block: Response, shots: Array) -> tuple[Array, Array]:
    """Returns the times [s] of the second method's steps, shape (m,), and its states, shape
    (m, d)."""
    begin = block.orbit.breakpoints[:-1, None]
    lengths = np.diff(block.orbit.breakpoints)[:, None]
    states = block.states[:-1, None] + shots.real[:, :-1, :, 0]
    times = begin + lengths * (np.arange(SECOND_METHOD_STEPS) / SECOND_METHOD_STEPS)
    return times.reshape(-1), states.reshape(times.size, -1)


def _scales(sizes: Array, least: float = 0.0) -> Array:
    """Returns the scales of a state, shape (d,): one scale for all coordinates, one for all rates.

    `sizes` are the magnitudes of the state's numbers, shape (d,). The scale of the rates is at
    least `least` [1/s] times the scale of the coordinates.
    """
    coordinate, rate = sizes.reshape(2, -1).max(axis=1)
    rate = max(rate, least * coordinate)
    return np.repeat((coordinate or 1.0, rate or 1.0), len(sizes) // 2)


def _next_block(
    system: SmoothSystem, track: _Track, watch: Callable[[float], None]
) -> tuple[Response | None, float, str]:
    """Returns up to STEPS_BETWEEN_CHECKS further steps of collocation, the length of the next step
    [s], and the reason why there are no more steps, else an empty text.

    If no step can be taken, the steps are None. Before each step `watch` is called with the time
    [s] at which the track ends.
    """
    rule = gauss_collocation(CERTIFIED_STAGES)
    step = track.step
    state = track.end
    time = track.reached
    times = [time]
    states = [state]
    slopes = list[Array]()
    while len(slopes) < STEPS_BETWEEN_CHECKS and step >= SMALLEST_STEP_RATIO * track.step:
        watch(track.reached)
        guess = step * system.slope(time, state)
        scale = _scales(np.max([track.size, np.abs(state), np.abs(guess)], axis=0))
        right = _right_hand_side(system, time + step * rule.nodes, step)
        increments = collocate(rule, right, state, np.tile(guess, (CERTIFIED_STAGES, 1)), scale)
        if increments is None or not rule.truncation(increments, scale) <= RESOLVED_COEFFICIENT:
            step /= 2
            continue
        time = time + step
        state = state + rule.weights @ increments
        times.append(time)
        states.append(state)
        slopes.append(increments / step)
        high_terms = np.abs(rule.spectrum[FIRST_HIGH_DEGREE:] @ increments / scale)
        smooth = high_terms.max() <= CERTIFIED_STAGES * RESOLVED_COEFFICIENT
        within_reach = 2 * step * _fastest_rate(system, time, state) <= MAX_STEP_TIME_CONSTANTS
        if smooth and within_reach and time % (2 * step) == 0.0:
            step *= 2
    why = "" if len(slopes) == STEPS_BETWEEN_CHECKS else "there it is too fast to follow"
    if not slopes:
        return None, step, why
    return Response(TimeGrid(np.array(times)), np.array(states), np.array(slopes)), step, why


def _right_hand_side(system: SmoothSystem, times: Array, step: float) -> RightHandSide:
    """Returns the right-hand side of a system for collocation: its rates times a `step` [s], at the
    `times` [s] of the nodes."""

    def rates(states: Array, with_jacobian: bool) -> tuple[Array, Array]:
        """Returns the rates at the nodes and, `with_jacobian`, their derivatives by the states."""
        slopes = step * system.slope(times, states.T).T
        if not with_jacobian:
            return slopes, slopes  # the second array is not read
        return slopes, step * np.moveaxis(system.jacobian(times, states.T), -1, 0)

    return rates


def _second_integration(system: SmoothSystem, block: Response) -> Array:
    """Returns the change of the state since each step's start, after each of SECOND_METHOD_STEPS of
    a step, by the second method.

    Imaginary parts carry the derivatives by the start and the parameters. The shape is (steps,
    SECOND_METHOD_STEPS + 1, d, d + parameters).
    """
    begin = block.orbit.breakpoints[:-1]
    lengths = np.diff(block.orbit.breakpoints)
    starts = block.states[:-1].T
    values = system.perturbed()
    size = len(starts)
    start = np.zeros((size, size + len(system.parameters), len(begin)), dtype=complex)
    start.real = starts[:, None]
    start.imag[:, :size] = IMAGINARY_STEP * np.eye(size)[..., None]

    def slope(time: Any, state: Any) -> Any:
        return system.slope(time, state, values)

    changes = [np.zeros_like(start)]
    for part in range(SECOND_METHOD_STEPS):
        times = begin + lengths * (part / SECOND_METHOD_STEPS)
        change = order_8().change(
            slope, times, start + changes[-1], lengths / SECOND_METHOD_STEPS
        )
        changes.append(changes[-1] + change)
    return np.moveaxis(np.array(changes), -1, 0)


def _propagated_responses(
    response: Array, block: Response, shots: Array
) -> tuple[Array, Array]:
    """Returns the derivatives of the state by the inputs at the m times of a block, shape (m, d,
    inputs + 1), and at the block's end, shape (d, inputs + 1).

    The last column is the accumulated difference of the two methods.
    """
    size = len(response)
    rows = []
    for flow, difference in zip(_flow(shots), _step_differences(block, shots), strict=True):
        row = flow[..., :size] @ response
        row[..., size:-1] += flow[..., size:]
        rows.append(row[:-1])
        response = row[-1]
        response[:, -1] += difference
    return np.concatenate(rows), response


def _rounding_spread(variance: Array, block: Response, shots: Array) -> tuple[Array, Array]:
    """Returns the uncertainty of the state at the m times of a block, shape (m, d), and the
    covariance of the state at the block's end, shape (d, d).

    The uncertainty is SIGMAS standard deviations of the two methods' difference, plus the error of
    the polynomials in each step. The differences of single steps are independent.
    """
    size = len(variance)
    rows = []
    for flow, difference in zip(_flow(shots), _step_differences(block, shots), strict=True):
        tangents = flow[..., :size]
        rows.append(np.einsum("pij,jk,pik->pi", tangents[:-1], variance, tangents[:-1]))
        carried_variance = tangents[-1] @ variance @ tangents[-1].T
        variance = carried_variance + np.outer(difference, difference)
    times, states = _second_states(block, shots)
    polynomial_errors = np.abs(block.at(times) - states).reshape(
        len(rows), SECOND_METHOD_STEPS, size
    )
    largest_in_step = np.repeat(polynomial_errors.max(axis=1), SECOND_METHOD_STEPS, axis=0)
    random_walk = SIGMAS * np.sqrt(np.maximum(np.concatenate(rows), 0.0))
    return random_walk + largest_in_step, variance


def _flow(shots: Array) -> Array:
    """Returns the derivatives of the states in each step by its start and the parameters, shape
    (steps, SECOND_METHOD_STEPS + 1, d, d + parameters)."""
    flow = shots.imag / IMAGINARY_STEP
    size = flow.shape[2]
    flow[..., :size] += np.eye(size)
    return flow


def _step_differences(block: Response, shots: Array) -> Array:
    """Returns the second method's state less the first method's after each step, shape (steps,
    d)."""
    return np.asarray(shots.real[:, -1, :, 0] - np.diff(block.states, axis=0))
