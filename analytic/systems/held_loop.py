"""A joint under a controller that samples the state: its torque is held, and comes late.

At the times k T, k = 0, 1, ..., the controller reads the angle x and its rate x'. Its torque

    u_k = -(K x(k T) + D x'(k T))                                                              (1)

acts from k T + tau to (k + 1) T + tau; no torque acts before tau. With the moment of inertia J and
the damping c of the joint,

    J x'' = u - c x'.                                                                          (2)

Between two changes of u the motion is the exponential of a matrix (Astrom and Wittenmark 1997,
Computer-Controlled Systems, chapter 2). The state at the next sample is a linear function of the
state at this one and of the torques that still have to act: the loop is stable if all eigenvalues
of that map lie within the unit circle. A scheme that steps eq. 2 has such a map too, with its own
steps in place of the exponentials.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from plumbob.analytic.bisection import bisected
from plumbob.analytic.numerics.arithmetic import rounded_inputs
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, LinearResponse, Signals
from plumbob.analytic.sampled_control import SamplingTimes
from plumbob.analytic.stability import LoopQuantity

LOOP_OBSERVABLES = ("theta", "theta_dot")
# Roundings of each parameter in the uncertainty: the factor of a servo whose motor is not held
LOOP_ROUNDINGS = 12.0
MOST_PERIODS = 1_000_000  # most samples of a motion, which take some seconds
# Most periods of a delay: the matrix of the loop has a row for each
MOST_DELAY = 200
Flow = tuple[Array, Array]
"""Motion over a time under constant controls: the matrix of the state, shape (2, 2) or (n, n), and
the effect of a unit of the torque, shape (2,), or of each control, shape (n, m)."""
# Factors of a hold or of gains at which stability is tried: every SCAN_RATIO up to SCAN_END
SCAN_RATIO, SCAN_END = 1.02, 1000.0
SCAN_PARTS = 100  # delays that are tried in a period
LIMIT_WIDTH = 1e-12  # relative width of the last bracket of a limit


@dataclass(frozen=True)
class HeldLoop(LinearResponse):
    """Eq. 1 and 2: the moment of `inertia` J [kg m^2], the `damping` c [N m s/rad], the `stiffness`
    K [N m/rad] and the `rate_gain` D [N m s/rad] of the controller, which samples every `hold` [s]
    and acts `delay` [s] later; `theta` [rad] and its rate at time 0. Raises ParameterError.

    >>> loop = HeldLoop(1.0, 0.0, 1.0, 1.0, 0.5, 0.0, 1.0, 0.0)
    >>> round(loop.limit("hold"), 9)
    2.0
    """

    inertia: float
    damping: float
    stiffness: float
    rate_gain: float
    hold: float
    delay: float
    theta: float
    theta_dot: float

    def __post_init__(self) -> None:
        if self.delay > MOST_DELAY * self.hold:
            raise ParameterError("delay", self.delay, f"at most {MOST_DELAY} times the hold")

    @property
    def times(self) -> SamplingTimes:
        """The times of samples, and of the answers to them."""
        return SamplingTimes(self.hold, self.delay)

    @property
    def gains(self) -> Array:
        """The gains of eq. 1: K of the angle and D of the rate, shape (2,)."""
        return np.array([self.stiffness, self.rate_gain])

    @cached_property
    def delay_in_holds(self) -> tuple[int, float]:
        """The number of whole holds in the delay, and the remaining time [s], at most a hold."""
        whole_holds = math.floor(self.delay / self.hold)
        remainder = self.delay - whole_holds * self.hold
        return whole_holds, min(max(remainder, 0.0), self.hold)

    def flows(self, times: Array) -> tuple[Array, Array]:
        """Returns the exact flow of eq. 2 over each of `times` [s], shape (n,): matrices, shape (n,
        2, 2), and effects of a unit of torque, shape (n, 2)."""
        from scipy.linalg import expm

        slowing = -self.damping / self.inertia
        rates = np.array([[0.0, 1.0, 0.0], [0.0, slowing, 1.0 / self.inertia], [0.0] * 3])
        exponentials = expm(rates * np.asarray(times)[:, None, None])
        return exponentials[:, :2, :2], exponentials[:, :2, 2]

    def flow(self, time: float) -> Flow:
        """Returns the exact flow of eq. 2 over a time [s]."""
        matrices, effects = self.flows(np.array([time]))
        return matrices[0], effects[0]

    def observe(self, times: Array) -> Signals:
        """Exact x [rad] and x' [rad/s] at `times` [s], shape (n,). Raises ParameterError for more
        than MOST_PERIODS periods."""
        times = np.asarray(times, dtype=float)
        numbers = np.floor(times / self.hold).astype(np.int64)
        last = int(numbers.max(initial=0))
        if last > MOST_PERIODS:
            least = float(times.max()) / MOST_PERIODS
            raise ParameterError("hold", self.hold, f"at least {least:g} s for this duration")
        _, switch = self.delay_in_holds  # time after a sample at which the torque changes
        samples, torques = self._samples(last)
        since = times - numbers * self.hold
        states = self._moved(samples[numbers], np.clip(since, 0.0, switch), torques[numbers])
        after_switch = np.maximum(since - switch, 0.0)
        states = self._moved(states, after_switch, torques[numbers + 1])
        return dict(zip(LOOP_OBSERVABLES, states.T.copy(), strict=True))

    def _moved(self, states: Array, durations: Array, torques: Array) -> Array:
        """Returns `states`, shape (n, 2), after `durations` [s] under constant `torques` [N m],
        shape (n,) each."""
        matrices, effects = self.flows(durations)
        return np.asarray(
            np.einsum("nij,nj->ni", matrices, states) + effects * torques[:, None]
        )

    def _samples(self, last: int) -> tuple[Array, Array]:
        """Returns the states at the samples up to the number `last`, shape (last + 1, 2), and the
        torques in the order in which they act, shape (last + 2 + whole holds of the delay,). The
        torques that act before the first answer are zero."""
        whole_holds, switch = self.delay_in_holds
        early = self.flow(switch)
        late = self.flow(self.hold - switch)
        states = np.zeros((last + 1, 2))
        torques = np.zeros(last + 2 + whole_holds)
        state = np.array([self.theta, self.theta_dot])
        for k in range(last + 1):
            states[k] = state
            torques[k + whole_holds + 1] = -self.gains @ state
            state = early[0] @ state + early[1] * torques[k]
            state = late[0] @ state + late[1] * torques[k + 1]
        return states, torques

    def uncertainty(self, times: Array) -> Signals:
        """Bound on the error of each observable, shape (n,), by the rounding of each parameter."""
        return rounded_inputs(self, lambda loop: loop.observe(times), LOOP_ROUNDINGS)

    def changed(self, quantity: LoopQuantity, value: float) -> HeldLoop:
        """Returns the loop with another hold [s], another delay [s], or both gains times a factor.
        With another hold the delay stays as many periods."""
        if quantity == "hold":
            return replace(self, hold=value, delay=self.delay / self.hold * value)
        if quantity == "delay":
            return replace(self, delay=value)
        return replace(self, stiffness=value * self.stiffness, rate_gain=value * self.rate_gain)

    def multiplier(self) -> float:
        """Returns the largest magnitude of the eigenvalues of the exact map over a hold."""
        whole_holds, switch = self.delay_in_holds
        early = self.flow(switch)
        late = self.flow(self.hold - switch)
        return loop_multiplier(early, late, self.gains, whole_holds)

    def limit(self, quantity: LoopQuantity) -> float:
        """Returns the hold [s], the delay [s] or the factor of both gains up to which the loop is
        stable: the end of its first stable interval. It is 0 if no value that is tried is stable,
        and infinite if that interval has no end among them."""

        def stable(value: float) -> bool:
            """Whether the loop is stable with another value of the quantity."""
            return self.changed(quantity, value).multiplier() < 1.0

        return first_unstable(stable, self.scan(quantity))

    def scan(self, quantity: LoopQuantity) -> Array:
        """Returns increasing values of a quantity at which stability is tried, shape (n,)."""
        if quantity == "delay":
            return np.linspace(0.0, MOST_DELAY, MOST_DELAY * SCAN_PARTS + 1) * self.hold
        count = round(math.log(SCAN_END) / math.log(SCAN_RATIO))
        present = self.hold if quantity == "hold" else 1.0
        return np.asarray(present * SCAN_RATIO ** np.arange(-count, count + 1.0))


def loop_multiplier(early: Flow, late: Flow, gains: Array, whole_holds: int) -> float:
    """Returns the largest magnitude of the eigenvalues of `loop_map`."""
    return float(np.abs(np.linalg.eigvals(loop_map(early, late, gains, whole_holds))).max())


def loop_map(early: Flow, late: Flow, gains: Array, whole_holds: int) -> Array:
    """Returns the matrix of the map over a hold of the state, n numbers, and of the controls that
    still have to act, m numbers for each of `whole_holds` + 1 samples, the newest first.

    Over the `early` flow the controls of `whole_holds` + 1 samples ago act, over the `late` flow
    the controls of `whole_holds` samples ago. Flows have matrices of shape (n, n) and effects of
    shape (n, m). The controller answers a state by minus the `gains`, shape (m, n), times the
    state; without m for a single control."""
    states = len(early[0])
    feedback = gains.reshape(-1, states)
    controls = len(feedback)
    first, second = (effect.reshape(states, controls) for _, effect in (early, late))
    size = states + controls * (whole_holds + 1)
    matrix = np.zeros((size, size))
    matrix[:states, :states] = late[0] @ early[0]
    matrix[:states, size - controls :] = late[0] @ first
    if whole_holds:
        acting = states + controls * (whole_holds - 1)
        matrix[:states, acting : acting + controls] += second
    else:
        matrix[:states, :states] -= second @ feedback
    matrix[states : states + controls, :states] = -feedback
    matrix[states + controls :, states : size - controls] = np.eye(controls * whole_holds)
    return matrix


def repeated_flow(flow: Flow, count: int) -> Flow:
    """Returns the motion over `count` repetitions of a flow under constant controls."""
    states = len(flow[0])
    effects = flow[1].reshape(states, -1)
    with_controls = np.eye(states + effects.shape[1])
    with_controls[:states, :states], with_controls[:states, states:] = flow[0], effects
    power = np.linalg.matrix_power(with_controls, count)
    return power[:states, :states], power[:states, states:]


def first_unstable(stable: Callable[[float], bool], values: Array) -> float:
    """Returns the value at which a loop that is `stable` at some of the increasing `values` ceases
    to be stable; 0 if none is stable, infinite if none after them is unstable."""
    last_stable: float | None = None
    for value in values.tolist():
        if stable(value):
            last_stable = value
        elif last_stable is not None:
            largest_stable, _ = bisected(stable, last_stable, float(value), _middle)
            return largest_stable
    return 0.0 if last_stable is None else math.inf


def _middle(low: float, high: float) -> float | None:
    """Returns the mean of two numbers; None if they differ by LIMIT_WIDTH, relative, or less."""
    return (low + high) / 2 if abs(high - low) > LIMIT_WIDTH * abs(high) else None
