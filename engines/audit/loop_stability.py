"""Stability of a model under a policy about a fixed point: up to which hold, delay and gain.

A policy samples the state at each control period. About a fixed point the steps of a hold and the
answers that still have to act make a linear map (analytic/systems/held_loop.py). The fixed point is
stable if all eigenvalues lie within the unit circle. Each end of an interval of stable values is
confirmed by nudged runs, which ask the policy itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from plumbob.analytic.bisection import bisected
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.stability import LOOP_QUANTITIES, LoopQuantity
from plumbob.analytic.systems.held_loop import Flow, loop_map, repeated_flow
from plumbob.engines.audit.stability import ABOVE, BELOW
from plumbob.engines.audit.user_models import quiet
from plumbob.engines.closed_loop import ClosedLoop, new_policy
from plumbob.engines.own_motion import NotCertifiable, NotControlled, OwnModel
from plumbob.engines.step_jacobian import NEUTRAL, state_after_step, step_jacobian
from plumbob.engines.stepper import Diverged
from plumbob.engines.tangent_space import TangentSpace, space_of_layout, state_row
from plumbob.models.border import must_be

MOST_HOLD = 2000  # [steps] longest hold that is tried
MOST_LATE = 20  # longest delay that is tried, in control periods
# Factors of a gain are tried in a geometric series of this ratio, up to the largest factor.
GAIN_RATIO, MOST_GAIN = 1.02, 1000.0
RESOLVED = 1e-3  # relative accuracy to which a limit of a gain is bisected
# [m, rad, ...] shift of the state by which a step is differentiated: the floor of the solver is
# 1e-16, and a double rounds such a difference by 1e-10
STEP_DIFFERENCE = 1e-6
# [m, rad, ...] shifts of the state by which a policy is differentiated: a network in single
# precision rounds by 1e-7
POLICY_DIFFERENCES = (1e-4, 1e-5)
SMOOTH = 0.02  # largest relative difference of the two derivatives of a smooth policy
# Magnitude of an eigenvalue above 1 that differences of 1e-6 cause in a direction that nothing
# holds, such as the place of a cart
NEUTRAL_GROWTH = 1e-6
AT_REST = 1e-9  # [m, rad, m/s, ...] largest change of a fixed point in a step
LOOP_NUDGE = 1e-6  # [m, rad, ...] largest change of the fixed point at which a run begins
# A run lasts until the mode has changed by the factor CHANGED, or for MOST_NUDGED_STEPS steps.
CHANGED, MOST_NUDGED_STEPS = 100.0, 200_000
Instability = Literal["drifts apart", "alternates from sample to sample", "oscillates"]


@dataclass(frozen=True)
class IntervalEnd:
    """An end of the stable values of a quantity: a hold or a delay [s], or a factor of the gain."""

    value: float
    confirmed: bool  # whether runs decay inside and grow outside
    why: str = ""  # why it is not confirmed
    # The joint or activation that moves most in the mode that grows beyond the end
    place: str = ""
    instability: Instability = "oscillates"  # how that mode grows
    frequency: float = 0.0  # [Hz] frequency of a mode that oscillates


@dataclass(frozen=True)
class StableInterval:
    """The stable values of a quantity about the loop's own."""

    quantity: LoopQuantity
    own: float
    low: IntervalEnd | None  # None: all smaller values that were tried are stable
    high: IntervalEnd | None  # None: all larger values that were tried are stable


@dataclass(frozen=True)
class LoopStability:
    """The stability of a model under a policy about a fixed point."""

    integrator: str
    step: float  # [s]
    hold: float  # [s]
    delay: float  # [s]
    state: Array  # the fixed point, shape (n,)
    control: Array  # the policy's answer there, shape (actuators,)
    multiplier: float  # factor by which a nudge grows in a period, at most
    by_jacobian: bool  # whether the policy has a `jacobian` of its own
    intervals: tuple[StableInterval, ...]  # empty if the loop itself is unstable

    @property
    def unstable(self) -> bool:
        """Whether the loop with its own hold, delay and gain is unstable."""
        return self.multiplier > 1.0 + NEUTRAL_GROWTH


@dataclass(frozen=True)
class LinearLoop:
    """A loop about a fixed point: the flow of a step, the gains that the policy is linear with, a
    hold and a delay in steps, and a factor of the gains."""

    flow: Flow
    gains: Array  # minus the derivative of the controls by the state, shape (m, n)
    hold: int
    delay: int
    factor: float = 1.0

    def changed(self, quantity: LoopQuantity, value: float) -> LinearLoop:
        """Returns the loop with another hold or delay, in steps, or another factor of the gains.
        With another hold the delay stays as many periods, rounded to a step."""
        if quantity == "hold":
            delay = round(self.delay / self.hold * value)
            return replace(self, hold=round(value), delay=delay)
        if quantity == "delay":
            return replace(self, delay=round(value))
        return replace(self, factor=value)

    @cached_property
    def matrix(self) -> Array:
        """The map over a hold of the state and of the controls that still have to act."""
        whole, rest = divmod(self.delay, self.hold)
        late = repeated_flow(self.flow, self.hold - rest)
        return loop_map(repeated_flow(self.flow, rest), late, self.factor * self.gains, whole)

    @cached_property
    def multiplier(self) -> float:
        """The largest magnitude of the eigenvalues of the map over a hold; infinite if the map
        overflows."""
        if not np.isfinite(self.matrix).all():
            return math.inf
        return float(np.abs(np.linalg.eigvals(self.matrix)).max())

    @property
    def stable(self) -> bool:
        """Whether no nudge grows."""
        return self.multiplier <= 1.0 + NEUTRAL_GROWTH

    def ends(self, quantity: LoopQuantity) -> tuple[float | None, float | None]:
        """Returns the ends of the stable values of a quantity about the loop's own: the last stable
        value in steps below it and above it, or factor; None where all that are tried are
        stable."""
        if quantity == "gain":
            count = round(math.log(MOST_GAIN) / math.log(GAIN_RATIO))
            powers = GAIN_RATIO ** np.arange(1.0, count + 1)
            return self._end(quantity, 1.0, 1.0 / powers), self._end(quantity, 1.0, powers)
        own = self.hold if quantity == "hold" else self.delay
        first = 1 if quantity == "hold" else 0
        last = MOST_HOLD if quantity == "hold" else MOST_LATE * self.hold
        below = np.arange(own - 1.0, first - 1.0, -1.0)
        return self._end(quantity, own, below), self._end(
            quantity, own, np.arange(own + 1.0, last + 1.0)
        )

    def _end(self, quantity: LoopQuantity, own: float, values: Array) -> float | None:
        """Returns the last stable value of a quantity on the way from the loop's own along
        `values`; None if all are stable."""
        held = own
        for value in values.tolist():
            if not self.changed(quantity, value).stable:
                return held if quantity != "gain" else self._bisected_gain(held, value)
            held = value
        return None

    def _bisected_gain(self, held: float, failed: float) -> float:
        """Returns the limit of the gain between a factor that is stable and one that is not."""

        def middle(low: float, high: float) -> float | None:
            """Returns the mean of two factors; None if they are close."""
            return (low + high) / 2 if abs(high - low) > RESOLVED * low else None

        return bisected(lambda value: self.changed("gain", value).stable, held, failed, middle)[
            0
        ]


@dataclass(frozen=True)
class FedBackModel:
    """A model with its steps under a policy: `hold` steps a sample, whose answer acts `delay` steps
    later."""

    model: OwnModel
    loop: ClosedLoop
    hold: int
    delay: int

    @cached_property
    def space(self) -> TangentSpace:
        """The tangent space of the model's states."""
        return space_of_layout(self.model.layout)

    @cached_property
    def stepper(self) -> Any:
        """Steps of the model that are smooth functions of the state."""
        return self.model.function_stepper(self.model.integrator, self.model.step)

    def answer(self, state: Array) -> Array:
        """Returns the answer of a new run's policy to a state at time 0. Raises ParameterError and
        NotControlled."""
        return self.loop.new_run()(0.0, state)

    def check_memory(self, state: Array) -> None:
        """Raises ParameterError unless the policy answers a state alike after other states, and at
        another time."""
        first = self.answer(state)
        ask = self.loop.new_run()
        beside = self.space.shifted(state, np.full(self.space.size(state), LOOP_NUDGE))
        for other in (state, beside, beside):
            ask(0.0, other)
        if not np.array_equal(ask(0.0, state), first):
            wanted = "one without a memory: it answers a state otherwise after other states"
            raise ParameterError("policy", self.loop.name, wanted)
        if not np.array_equal(ask(self.hold * self.model.step, state), first):
            wanted = "one that does not depend on time: a fixed point has none"
            raise ParameterError("policy", self.loop.name, wanted)

    def flow(self, state: Array, control: Array) -> Flow:
        """Returns the derivatives of a step in the tangent space by the state, shape (n, n), and by
        the control, shape (n, m)."""
        by_state = step_jacobian(self.stepper, self.space, state, control, STEP_DIFFERENCE)
        shifts = STEP_DIFFERENCE * np.eye(control.size)
        ahead, behind = (
            np.array(
                [
                    state_after_step(self.stepper, self.space, state, control + sign * shift)
                    for shift in shifts
                ]
            ).reshape(control.size, state.size)
            for sign in (1.0, -1.0)
        )
        effects = self.space.differences(ahead, behind).T / (2.0 * STEP_DIFFERENCE)
        return by_state, effects

    def feedback(self, state: Array) -> Array:
        """Returns the derivative of the controls by the state in the tangent space, shape (m, n):
        by the policy's own `jacobian`, or by differences. Raises ParameterError."""
        own = getattr(new_policy(self.loop.policy), "jacobian", None)
        size = self.space.size(state)
        if callable(own):
            return self._own_derivative(own, state, size)
        rough, fine = (self._differences(state, size, h) for h in POLICY_DIFFERENCES)
        if np.abs(rough - fine).max() > SMOOTH * np.abs(fine).max():
            wanted = "one that is smooth at the fixed point, or that has a jacobian"
            raise ParameterError("policy", self.loop.name, wanted)
        return fine

    def _own_derivative(self, own: Callable[..., Any], state: Array, size: int) -> Array:
        """Returns the derivative that a policy's `jacobian` gives by changes of positions and
        velocities, with zeros for activations, shape (m, n). Raises ParameterError."""
        moving = 2 * self.space.velocities
        shape = (self.loop.count, moving)
        wanted = f"one whose jacobian(time, qpos, qvel) returns finite numbers of shape {shape}"
        velocities = self.loop.velocities
        with must_be(wanted, "policy", self.loop.name):
            given = own(0.0, state[: velocities.start].copy(), state[velocities].copy())
            values = np.asarray(given, dtype=float).reshape(shape)
        if not np.isfinite(values).all():
            raise ParameterError("policy", self.loop.name, wanted)
        return np.hstack([values, np.zeros((self.loop.count, size - moving))])

    def _differences(self, state: Array, size: int, difference: float) -> Array:
        """Returns central differences of the policy of a size [m, rad, ...], shape (m, n)."""
        columns = [
            (
                self.answer(self.space.shifted(state, shift))
                - self.answer(self.space.shifted(state, -shift))
            )
            / (2.0 * difference)
            for shift in difference * np.eye(size)
        ]
        return np.array(columns).T

    def linear(self, state: Array, control: Array) -> LinearLoop:
        """Returns the loop about a fixed point."""
        return LinearLoop(
            self.flow(state, control), -self.feedback(state), self.hold, self.delay
        )

    @quiet()
    def fixed_point(self, state: Array) -> tuple[Array, Array]:
        """Returns a state near a `state` that a step under the policy's answer leaves as it is, and
        that answer, by Newton's method. Raises NotCertifiable if there is none."""
        before = math.inf
        while True:
            control = self.answer(state)
            after = state_after_step(self.stepper, self.space, state, control)
            moved = self.space.differences(after, state)
            size = float(np.abs(moved).max())
            if not size < before:
                break
            by_state, effects = self.flow(state, control)
            free = np.eye(len(by_state)) - by_state - effects @ self.feedback(state)
            if not np.isfinite(free).all():
                break
            nearest, before = (state, control), size
            shift = np.asarray(np.linalg.lstsq(free, moved, NEUTRAL)[0], float)
            state = self.space.shifted(state, shift)
        if before < AT_REST:
            return nearest
        raise NotCertifiable("no fixed point under the policy near the start")

    @quiet()
    def grows(self, point: tuple[Array, Array], loop: LinearLoop) -> bool | None:
        """Returns whether a run nudged at a fixed point grows with the hold, the delay and the
        factor of the gains of a `loop`, which tells how long it has to last; None if that is too
        long."""
        state, control = point
        rate = abs(math.log(loop.multiplier)) if math.isfinite(loop.multiplier) else 1.0
        periods = 4 + math.ceil(math.log(CHANGED) / max(rate, 1e-9))
        if periods * loop.hold > MOST_NUDGED_STEPS:
            return None
        ask = self.loop.new_run()
        stepper = self.stepper
        shift = np.random.default_rng(0).uniform(
            -LOOP_NUDGE, LOOP_NUDGE, self.space.size(state)
        )
        whole, rest = divmod(loop.delay, loop.hold)
        waiting = [control] * (whole + 1)
        stepper.put(self.space.state_of(self.space.shifted(state, shift)))
        sizes = []
        try:
            for _ in range(periods):
                present = state_row(stepper.state())
                sizes.append(float(np.abs(self.space.differences(present, state)).max()))
                waiting.append(control + loop.factor * (ask(0.0, present) - control))
                for number, count in ((0, rest), (1, loop.hold - rest)):
                    if count:
                        stepper.advance(np.tile(waiting[number], (count, 1)), count)
                waiting.pop(0)
        except (Diverged, NotControlled):
            return True
        if not np.isfinite(sizes).all():
            return True
        quarter = len(sizes) // 4
        return not max(sizes[-quarter:]) < max(sizes[:quarter])


@quiet()
def loop_stability(of: FedBackModel, start: Array) -> LoopStability:
    """Returns the stability of a model under a policy about the fixed point near a start. Raises
    ParameterError for a policy that has a memory, depends on time or is not smooth, and
    NotCertifiable if there is no fixed point."""
    of.check_memory(start)
    try:
        point = of.fixed_point(start)
        loop = of.linear(*point)
        intervals = tuple(_intervals(of, point, loop)) if loop.stable else ()
    except NotControlled as why:
        wanted = f"one that returns finite numbers; {why}"
        raise ParameterError("policy", of.loop.name, wanted) from None
    step = of.model.step
    return LoopStability(
        integrator=of.model.integrator,
        step=step,
        hold=of.hold * step,
        delay=of.delay * step,
        state=point[0],
        control=point[1],
        multiplier=loop.multiplier,
        by_jacobian=hasattr(new_policy(of.loop.policy), "jacobian"),
        intervals=intervals,
    )


def _intervals(
    of: FedBackModel, point: tuple[Array, Array], loop: LinearLoop
) -> Iterator[StableInterval]:
    """Yields the stable intervals of the hold, the delay and the gain of a loop."""
    owns = {"hold": float(loop.hold), "delay": float(loop.delay), "gain": 1.0}
    for quantity in LOOP_QUANTITIES:
        unit = 1.0 if quantity == "gain" else of.model.step
        low, high = loop.ends(quantity)
        yield StableInterval(
            quantity=quantity,
            own=unit * owns[quantity],
            low=None if low is None else _end(of, point, loop, quantity, low, BELOW),
            high=None if high is None else _end(of, point, loop, quantity, high, ABOVE),
        )


def _end(
    of: FedBackModel,
    point: tuple[Array, Array],
    loop: LinearLoop,
    quantity: LoopQuantity,
    value: float,
    outwards: float,
) -> IntervalEnd:
    """Returns an end of the stable values of a quantity, in steps, or factor. `outwards` is the
    multiple of the end at which runs must grow; they must decay at its reciprocal."""
    inner, outer = value / outwards, value * outwards
    if quantity != "gain":
        away = 1 if outwards > 1.0 else -1
        inner = min(value - away, round(inner), key=lambda n: away * n)
        outer = max(value + away, round(outer), key=lambda n: away * n)
    within, beyond = loop.changed(quantity, inner), loop.changed(quantity, outer)
    why = ""
    if min(inner, outer) < (1 if quantity == "hold" else 0):
        why = "the end is within a step of the smallest value"
    elif of.grows(point, within) is not False:
        why = "runs 10 % inside do not decay"
    elif of.grows(point, beyond) is not True:
        why = "runs 10 % outside do not grow"
    place, instability, frequency = _growing_mode(of, point, beyond)
    unit = 1.0 if quantity == "gain" else of.model.step
    return IntervalEnd(unit * value, not why, why, place, instability, frequency)


def _growing_mode(
    of: FedBackModel, point: tuple[Array, Array], loop: LinearLoop
) -> tuple[str, Instability, float]:
    """Returns the joint or activation that moves most in the mode of a loop that grows fastest, how
    it grows, and its frequency [Hz]."""
    if not np.isfinite(loop.matrix).all():
        return "", "drifts apart", 0.0
    factors, modes = np.linalg.eig(loop.matrix)
    first = int(np.argmax(np.abs(factors)))
    factor = factors[first]
    size = len(loop.flow[0])
    place = of.model.place(*point, np.abs(modes[:size, first])).name
    frequency = abs(float(np.angle(factor))) / (2.0 * math.pi * loop.hold * of.model.step)
    if abs(factor.imag) > NEUTRAL_GROWTH:
        return place, "oscillates", frequency
    return place, "drifts apart" if factor.real > 0 else "alternates from sample to sample", 0.0
