"""A certified reference of any smooth system: two independent integrations of high order.

The first is Gauss collocation, whose polynomials are resolved to round-off, so that they give the
motion at any time. The second is an explicit method of order 8 in many small steps. It runs over
all steps of the first at once, each from where that begins; its distance from where the next
begins, propagated by the motion's own linearisation, is the difference of the two motions (parallel
shooting: Bellen and Zennaro 1989, J. Comput. Appl. Math. 25, 341). The same run carries the
linearisation, by the start and by the parameters, as imaginary parts.

Both methods round. Rounding errors of different steps are independent, so that the two motions may
agree by chance where neither is exact. The variance of their difference does not cancel: it is the
sum of the squares of what each step's difference has become.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.collocation import (
    RightHandSide,
    TimeGrid,
    collocate,
    gauss_collocation,
)
from plumbob.analytic.numerics.linear_flow import Response
from plumbob.analytic.numerics.smooth.smooth_system import TINY, SmoothSystem
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Signals, remembered
from plumbob.analytic.tableau import order_8

STAGES = 20
BLOCK = 32  # steps of the first method that the second runs over at once
PARTS = 24  # steps of the second method in one of the first
RESOLVED = 1e-15  # of the state: the last Legendre coefficients of a step; a tenth is round-off
SMOOTHER = 2 * STAGES // 3  # coefficients from this degree on decide whether a step may double
REACH = 4.0  # of the longest step: at most so many time constants of the fastest deviation
SMALLEST = 2.0**-24  # of the first step
SIGMAS = 3.0  # standard deviations of the random walk that the steps' differences make
SURE = 1e-3  # of its largest value: a motion that is known no better is not certified


@dataclass(frozen=True)
class _Track:
    """A motion as far as it is known; d numbers of state, c inputs."""

    step: float  # [s], the next one's
    solution: Response | None  # the first method's, shape (d,)
    end: Array  # its last state, shape (d,)
    response: Array  # of that by each input and, in the last column, the difference, (d, c + 1)
    variance: Array  # covariance of the end by rounding in all steps, shape (d, d)
    size: Array  # largest magnitudes so far, shape (d,)
    apart: Array  # largest difference of the two methods so far, shape (d,)
    times: Array  # [s] at which what follows is known, shape (m,)
    doubts: Array  # the uncertainty then, shape (m, d)
    until: float = math.inf  # [s] to where the motion is certified
    why: str = ""  # it is not certified further

    @property
    def reached(self) -> float:
        """The time that the first method has reached [s]."""
        return 0.0 if self.solution is None else self.solution.orbit.duration


@dataclass(frozen=True, eq=False)
class CertifiedMotion:
    """The motion of a `system`; a `Reference`. It is integrated as far as requested, and kept.
    Raises ParameterError for times beyond what double precision determines."""

    system: SmoothSystem
    _known: list[_Track] = field(default_factory=list, repr=False)

    @remembered
    def observe(self, times: Array) -> Signals:
        """Coordinates and rates at `times` [s], shape (n,), by name."""
        return self.system.observed(self._track(times)[1].T)

    def uncertainty(self, times: Array) -> Signals:
        """Sum, shape (n,) each, of the largest difference of the two methods so far, SIGMAS
        standard deviations of that difference, the error of the first method's polynomials, and the
        effect of rounded inputs."""
        track, states = self._track(times)
        after = np.searchsorted(track.times, times, side="right")
        before = track.doubts[after - 1]
        last = len(track.doubts) - 1
        doubts = np.maximum(before, track.doubts[np.minimum(after, last)])
        return self.system.doubts(states.T, doubts.T)

    def _track(self, times: Array) -> tuple[_Track, Array]:
        """The track up to the last of `times` [s], and the states then, shape (n, d)."""
        track = self._until(times)
        assert track.solution is not None
        return track, track.solution.at(np.asarray(times))

    def certify(self, last: float, watch: Callable[[float], None]) -> None:
        """Integrate the motion up to `last` [s], and keep it. `watch` is called before every step
        with the time [s] up to which the motion is certified. If `watch` raises, the motion up to
        that time is kept, with the same bits as in a longer integration."""
        with np.errstate(all="ignore"):  # what overflows is not certified
            track = self._known[0] if self._known else _begun(self.system)
            while not track.why and (track.solution is None or track.reached < last):
                track = _extended(self.system, track, watch)
                self._known[:] = [track]

    def known_until(self, last: float) -> float:
        """The time up to `last` [s] until which the motion is certified."""
        try:
            self._until(np.array([last]))
        except ParameterError:
            return self._known[0].until
        return last

    def nonlinearity(self, times: Array, errors: Signals) -> float:
        """The rates' nonlinear response to errors of the state, shape (n,) each, over the linear
        one."""
        states = self.system.state(self.observe(times))
        nothing = np.zeros(len(times))
        moved = self.system.state(defaultdict(lambda: nothing, errors))
        linear = np.einsum("ijn,jn->in", self.system.jacobian(times, states), moved)
        rates = (self.system.slope(times, z) for z in (states + moved, states))
        remainder = np.subtract(*rates) - linear
        largest = float(np.abs(linear).max())
        return float(np.abs(remainder).max()) / largest if largest else 0.0

    def _until(self, times: Array) -> _Track:
        """The track up to the last of `times` [s] or beyond; raises ParameterError."""
        last = float(np.max(times, initial=0.0))
        self.certify(last, lambda reached: None)
        track = self._known[0]
        if last > track.until or track.solution is None:
            raise ParameterError("times", last, f"at most {track.until:.4g} s: {track.why}")
        return track


def _begun(system: SmoothSystem) -> _Track:
    start = system.start
    size = len(start)
    count = len(start) + len(system.parameters)
    rate = _fastest(system, 0.0, start)
    step = 2.0 ** math.floor(-math.log2(rate)) if 0.0 < rate < math.inf else 1.0
    response = np.eye(size, count + 1)
    exact = np.zeros((size, size))
    none = np.empty((0, size))
    return _Track(
        step, None, start, response, exact, np.abs(start), exact[0], np.empty(0), none
    )


def _fastest(system: SmoothSystem, time: float, state: Array) -> float:
    """Largest rate [1/s] at which small deviations change; infinite where it is not known."""
    jacobian = system.jacobian(time, state[:, None])[..., 0]
    if not np.isfinite(jacobian).all():
        return math.inf
    return float(np.abs(np.linalg.eigvals(jacobian)).max())


def _extended(system: SmoothSystem, track: _Track, watch: Callable[[float], None]) -> _Track:
    """The track, longer by up to BLOCK steps of collocation, with the bound on the error at each
    new time, which a second, independent integration gives."""
    block, step, why = _collocated(system, track, watch)
    if block is None:
        return replace(track, until=min(track.until, track.reached), why=why)
    shots = _shot(system, block)
    times, states = _between(block, shots)
    responses, response = _carried(track.response, block, shots)
    spread, variance = _spread(track.variance, block, shots)
    size = np.maximum(track.size, np.abs(states).max(axis=0))
    apart = np.concatenate([track.apart[None], np.abs(responses[..., -1])])
    apart = np.maximum.accumulate(apart)[1:]
    doubts = apart + spread + ULP * _condition(system, times, states, responses, size)
    lost = ~np.all(doubts <= SURE * _scales(size, _rate(block)), axis=1)
    until = block.orbit.duration if why else track.until
    if lost.any():
        until = float(times[lost.argmax()])
        why = "double precision determines it no further"
    return _Track(
        step,
        block if track.solution is None else track.solution.followed_by(block),
        block.states[-1],
        response,
        variance,
        size,
        apart[-1],
        np.concatenate([track.times, times]),
        np.concatenate([track.doubts, doubts]),
        until,
        why,
    )


def _condition(
    system: SmoothSystem, times: Array, states: Array, responses: Array, size: Array
) -> Array:
    """Change of the states, shape (m, d), in units of ULP, by one unit in the last place of every
    input and of the times. `size` has the largest magnitudes of the state so far, shape (d,)."""
    condition = np.abs(states) + np.abs(responses[..., :-1]) @ (
        np.append(size, np.ones(len(system.parameters)))
    )
    return np.asarray(condition + np.abs(times * system.slope(times, states.T)).T)


def _rate(block: Response) -> float:
    """Inverse of the longest step [1/s]."""
    return float(1.0 / np.diff(block.orbit.breakpoints).max())


def _between(block: Response, shots: Array) -> tuple[Array, Array]:
    """Times [s], shape (m,), of the second method's steps, and its states then, shape (m, d)."""
    begin = block.orbit.breakpoints[:-1, None]
    lengths = np.diff(block.orbit.breakpoints)[:, None]
    states = block.states[:-1, None] + shots.real[:, :-1, :, 0]
    times = begin + lengths * (np.arange(PARTS) / PARTS)
    return times.reshape(-1), states.reshape(times.size, -1)


def _scales(sizes: Array, least: float = 0.0) -> Array:
    """Scales of a state's numbers of these sizes, shape (d,): one of coordinates, and one of rates,
    at `least` [1/s] times that."""
    coordinate, rate = sizes.reshape(2, -1).max(axis=1)
    return np.repeat((coordinate or 1.0, max(rate, least * coordinate) or 1.0), len(sizes) // 2)


def _collocated(
    system: SmoothSystem, track: _Track, watch: Callable[[float], None]
) -> tuple[Response | None, float, str]:
    """Up to BLOCK steps of Gauss collocation from where a track ends, none where no step can be
    taken; the length of the next step [s], and why there is none. Before each step `watch` is
    called with the time [s] at which the track ends."""
    rule = gauss_collocation(STAGES)
    step = track.step
    state = track.end
    time = track.reached
    times = [time]
    states = [state]
    slopes = list[Array]()
    while len(slopes) < BLOCK and step >= SMALLEST * track.step:
        watch(track.reached)
        guess = step * system.slope(time, state)
        scale = _scales(np.max([track.size, np.abs(state), np.abs(guess)], axis=0))
        right = _scaled(system, time + step * rule.nodes, step)
        solved = collocate(rule, right, state, np.tile(guess, (STAGES, 1)), scale)
        if solved is None or not rule.truncation(solved, scale) <= RESOLVED:
            step /= 2
            continue
        time = time + step
        state = state + rule.weights @ solved
        times.append(time)
        states.append(state)
        slopes.append(solved / step)
        smooth = np.abs(rule.spectrum[SMOOTHER:] @ solved / scale).max() <= STAGES * RESOLVED
        followed = 2 * step * _fastest(system, time, state) <= REACH
        if smooth and followed and time % (2 * step) == 0.0:
            step *= 2
    why = "" if len(slopes) == BLOCK else "there it is too fast to follow"
    if not slopes:
        return None, step, why
    return Response(TimeGrid(np.array(times)), np.array(states), np.array(slopes)), step, why


def _scaled(system: SmoothSystem, times: Array, step: float) -> RightHandSide:
    """A system's rates times a `step` [s], at the `times` [s] of its nodes."""

    def rates(states: Array, wanted: bool) -> tuple[Array, Array]:
        slopes = step * system.slope(times, states.T).T
        jacobian = (
            step * np.moveaxis(system.jacobian(times, states.T), -1, 0) if wanted else slopes
        )
        return slopes, jacobian

    return rates


def _shot(system: SmoothSystem, block: Response) -> Array:
    """Change of the state since each step's start by the second method, in PARTS of a step, with
    its derivatives by the start and the parameters: (steps, PARTS + 1, d, d + parameters)."""
    begin = block.orbit.breakpoints[:-1]
    lengths = np.diff(block.orbit.breakpoints)
    starts = block.states[:-1].T
    values = system.perturbed()
    size = len(starts)
    state = np.zeros((size, size + len(system.parameters), len(begin)), dtype=complex)
    state.real = starts[:, None]
    state.imag[:, :size] = TINY * np.eye(size)[..., None]
    moved = [np.zeros_like(state)]
    for part in range(PARTS):
        moved.append(
            moved[-1]
            + order_8().change(
                lambda time, ahead: system.slope(time, ahead, values),
                begin + lengths * (part / PARTS),
                state + moved[-1],
                lengths / PARTS,
            )
        )
    return np.moveaxis(np.array(moved), -1, 0)


def _carried(response: Array, block: Response, shots: Array) -> tuple[Array, Array]:
    """Derivatives of the state by the inputs at the m known times of a block, shape (m, d, inputs +
    1), and at the block's end. The last column is the accumulated difference of the two methods."""
    size = len(response)
    rows = []
    for across, lacking in zip(_flow(shots), _missed(block, shots), strict=True):
        row = across[..., :size] @ response
        row[..., size:-1] += across[..., size:]
        rows.append(row[:-1])
        response = row[-1]
        response[:, -1] += lacking
    return np.concatenate(rows), response


def _spread(variance: Array, block: Response, shots: Array) -> tuple[Array, Array]:
    """Uncertainty of the state at all known times, shape (m, d), and its covariance at the block's
    end, shape (d, d). The uncertainty is SIGMAS standard deviations of the two methods' difference,
    whose parts from single steps are independent, and the error of the polynomials in each step."""
    size = len(variance)
    rows = []
    for across, lacking in zip(_flow(shots), _missed(block, shots), strict=True):
        flow = across[..., :size]
        rows.append(np.einsum("pij,jk,pik->pi", flow[:-1], variance, flow[:-1]))
        variance = flow[-1] @ variance @ flow[-1].T + np.outer(lacking, lacking)
    times, states = _between(block, shots)
    off = np.abs(block.at(times) - states).reshape(len(rows), PARTS, size).max(axis=1)
    walk = SIGMAS * np.sqrt(np.maximum(np.concatenate(rows), 0.0))
    return walk + np.repeat(off, PARTS, axis=0), variance


def _flow(shots: Array) -> Array:
    """Derivatives of the states in each step by its start and the parameters, shape
    (steps, PARTS + 1, d, d + parameters)."""
    flow = shots.imag / TINY
    size = flow.shape[2]
    flow[..., :size] += np.eye(size)
    return flow


def _missed(block: Response, shots: Array) -> Array:
    """The second method's state less the first's after each step, shape (steps, d)."""
    return np.asarray(shots.real[:, -1, :, 0] - np.diff(block.states, axis=0))
