"""The largest step that holds along a certified motion, the part that sets it, and changes that
raise it.

A limit is predicted from the Jacobian of one step at states along the motion. A nudge grows without
bounds if the step magnifies some mode of the nudge by more than the continuous motion does. The
modes of the step and of the continuous motion are matched by the rank of their magnitudes. Matching
by rank is optimal: if some matching has no mode that exceeds its partner, matching by rank has
none.

A limit is confirmed if nudged runs hold at steps below it and are lost along the motion at ABOVE
times it. If the runs are not lost there, the limit comes with the largest step at which they hold.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.bisection import bisected
from plumbob.analytic.reference import Array
from plumbob.analytic.stability import LOST_GROWTH
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.built_mechanism import BuiltSteppers
from plumbob.engines.audit.reference import largest_displacement
from plumbob.engines.audit.user_models import quiet
from plumbob.engines.method import Unsupported
from plumbob.engines.nudged_runs import NudgedRuns
from plumbob.engines.own_motion import (
    OUT_OF_TIME,
    Change,
    Element,
    NotCertifiable,
    OwnModel,
    Place,
    Script,
)
from plumbob.engines.step_jacobian import state_at_rest, step_jacobian
from plumbob.engines.tangent_space import TangentSpace, space_of_layout

STATES = 5  # number of states along the motion whose Jacobians are computed
BEYOND = 10.0  # largest step that is tried, as a multiple of the model's own step
# Growth of a mode in a step beyond the growth of the continuous motion that still counts as stable:
# a nudge grows a thousandfold in 142 steps. RK4 exceeds the margin within 1.2 % of the step at
# which |R(z)| = 1.
MARGIN = 0.05
SAFE = 0.5  # step at which every method holds, as a fraction of the shortest time constant
RATIO = 2.0  # ratio of successive steps of the search
RESOLVED = 0.02  # relative accuracy to which a limit is bisected
JACOBIAN_DIFFERENCES = (1e-6, 1e-7)  # [m, rad, ...] sizes of the differences of the Jacobians
# If a contact begins within a difference of states, the Jacobian is proportional to the reciprocal
# of the difference, and the state shows nothing: the factors by two differences have a larger ratio
# than this.
ALIKE = 1.5
TINY = 2.0**-24  # [s] a step so short that it shows the continuous motion
BELOW, ABOVE = 0.9, 1.1  # multiples of a limit at which nudged runs must hold, and be lost
# Multiples of a step at which a nudge must grow. The place where a body lands may decide the growth
# of a nudge at one step alone; a nudge that grows at all three grows at any step.
NEAR = (1.0, 0.99, 1.01)
SPREAD = 1.05  # ratio of successive steps of nudged runs
BETWEEN = 16  # number of steps that are tried between a limit divided by RATIO and the limit
SETTLED = 0.01  # [m/s, rad/s] largest velocity at the end of a run that has come to rest
# If a nudge much later in the run grows by less than this factor, the growth of the first nudge
# came from a landing alone.
LATER_GROWTH = 10.0
# Least ratio of a step to the finer step at which the growth of the motion itself is measured
FINER = 4
LEAST, MOST = 50, 400  # fewest and most steps of a nudged run
PATIENCE = 2.0  # multiple of the time allowed after which the search ends
FINE = 8  # steps in place of each step, for the motion of a model that a remedy changes
HELPS = 1.1  # least factor by which a remedy raises the limit
# Least factor by which a remedy raises the limit of the Jacobian at the state that sets it
RAISED = 1.05
NOTICED = 0.01  # least part of the growth that an element must explain to be named


@dataclass(frozen=True)
class Limit:
    """The largest step of a method; all smaller steps hold along the motion."""

    integrator: str  # an integrator of MuJoCo, or the name of an engine's method
    largest_step: float | None  # [s]; None if it lies beyond the steps that were tried
    # [s] by the Jacobian of a step; None if the Jacobian shows no limit
    predicted: float | None = None
    # The part that becomes unstable first: a joint, and its actuator, spring, damper or contact
    first: str = ""
    confirmed: bool = False  # whether nudged runs hold below the limit and are lost above it
    why: str = ""  # why the limit is not known or not confirmed
    index: int = 0  # control period of the state that sets the limit
    # [s] step from which a motion that comes to rest at smaller steps does not; None if there is
    # none
    chatters: float | None = None
    # [s] the largest step at which nudged runs along the motion hold; None if the limit is
    # confirmed
    holds_to: float | None = None

    @property
    def reach(self) -> float:
        """The largest step [s] that is known to hold: infinite if it lies beyond the steps that
        were tried, 0 if nothing is confirmed."""
        if not self.confirmed:
            return 0.0
        return math.inf if self.largest_step is None else self.largest_step


@dataclass(frozen=True)
class Remedy:
    """A change of the model that raises the limit of the first method."""

    change: Change
    limit: Limit
    moved: float  # [m] largest displacement of a body along the certified motion by the change


@dataclass(frozen=True)
class LargestSteps:
    """The limits of several methods, and remedies for the first method, the best remedy first."""

    limits: tuple[Limit, ...]
    remedies: tuple[Remedy, ...]
    step: float  # [s] the model's own
    start_only: bool = False  # whether only the start of the motion is known

    @property
    def own(self) -> Limit:
        """The limit of the first method, which is the model's own integrator unless methods are
        named."""
        return self.limits[0]

    @property
    def unstable(self) -> bool:
        """Whether nudged runs have confirmed that the model's own step is unstable."""
        return self.own.confirmed and self.own.reach < self.step


@dataclass(frozen=True)
class Point:
    """A state of the motion, and the rates of the modes of the continuous motion there."""

    index: int  # index of the control period
    state: Array
    control: Array
    rates: Array  # [1/s] complex, shape (n,)
    # Whether it stands for the state of rest near by, which differs from step to step
    rests: bool = False


@np.errstate(over="ignore")
def largest_excess(jacobian: Array, rates: Array, step: float) -> float:
    """Returns the largest factor by which a mode of a step [s] grows beyond its partner among the
    modes of the continuous motion, or beyond 1. `jacobian` is the derivative of the step, shape (n,
    n); `rates` [1/s] are those of the continuous modes, shape (n,)."""
    if not np.isfinite(jacobian).all():
        return math.inf
    stepped = np.sort(np.abs(np.linalg.eigvals(jacobian)))
    flow = np.exp(np.sort(rates.real) * step)
    return float((stepped / np.maximum(flow, 1.0)).max())


@dataclass(frozen=True)
class AuditedMotion:
    """A model along a certified motion, for the search for limits of steps. The steps are those of
    integrators of MuJoCo, or of the engine that `built` the model."""

    model: OwnModel
    script: Script
    states: Array  # at the ends of the periods that are known, shape (k, n)
    built: BuiltSteppers | None = None
    ends: float = math.inf  # [s] processor time at which the search ends

    @property
    def steppers(self) -> OwnModel | BuiltSteppers:
        """The source of steppers of the model."""
        return self.model if self.built is None else self.built

    def changed(self, change: Change) -> AuditedMotion:
        """A copy for the model with a change."""
        built = self.built and self.built.changed((change,))
        return replace(self, model=self.model.changed((change,)), built=built)

    @cached_property
    def space(self) -> TangentSpace:
        """The tangent space of the model's states."""
        return space_of_layout(self.model.layout)

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """States spread over the motion, including the first, the last, and the state of rest in
        which the motion may end: contacts at rest differ from step to step."""
        count = len(self.states)
        chosen = np.unique(np.linspace(0, count - 1, STATES).round().astype(int))
        return tuple(self.point(int(k)) for k in (*chosen, count))

    @quiet()
    def point(self, index: int) -> Point:
        """Returns the state at the beginning of the control period `index`; for the index after the
        last known state, the state of rest."""
        control = self.script.controls[min(index, len(self.script.controls) - 1)]
        last = len(self.states) - 1
        state = self.states[min(index, last)]
        stepper = self.model.function_stepper(self.model.integrator, TINY)
        about = (self.space, state, control)
        step = step_jacobian(stepper, *about, JACOBIAN_DIFFERENCES[0], ends=self.ends)
        rates = np.linalg.eigvals(step - np.eye(len(step))) / TINY
        return Point(index, state, control, np.asarray(rates), index > last)

    @quiet()
    def state_at(self, point: Point, method: str, step: float) -> Array | None:
        """Returns the state of a point at a step [s]; None if the step has no state of rest."""
        if not point.rests:
            return point.state
        stepper = self.steppers.function_stepper(method, step)
        return state_at_rest(stepper, self.space, point.state, point.control, self.ends)

    @quiet()
    def jacobian(
        self,
        point: Point,
        state: Array,
        method: str,
        step: float,
        difference: float = JACOBIAN_DIFFERENCES[0],
        directions: Array | None = None,
    ) -> Array:
        """Returns the derivative of a step [s] from a `state` under the control of a point, by
        differences of the given size, shape (m, m); times `directions`, shape (m, k), if given."""
        stepper = self.steppers.function_stepper(method, step)
        return step_jacobian(
            stepper, self.space, state, point.control, difference, directions, self.ends
        )

    def excess_at(self, point: Point, method: str, step: float) -> float:
        """Returns the largest factor by which one step [s] from a point magnifies a mode beyond the
        continuous motion; 1 if the step has no state of rest."""
        state = self.state_at(point, method, step)
        return 1.0 if state is None else self.excess_from(state, point, method, step)

    def excess_from(
        self,
        state: Array,
        point: Point,
        method: str,
        step: float,
        difference: float = JACOBIAN_DIFFERENCES[0],
    ) -> float:
        """Returns the largest factor by which one step [s] from the `state` of a point magnifies a
        mode beyond the continuous motion, by a Jacobian of differences of the given size."""
        jacobian = self.jacobian(point, state, method, step, difference)
        return largest_excess(jacobian, point.rates, step)

    def finely_stepped(self, integrator: str) -> Array:
        """Returns the states of a run with FINE times smaller steps, at the ends of the periods
        that are known."""
        parts = FINE * self.script.parts(self.model.step)
        controls = self.script.controls[: max(1, len(self.states) - 1)]
        return self.model.stepped(
            replace(self.script, controls=controls), integrator, parts
        ).states

    def lost(self, method: str, step: float, index: int = 0) -> bool:
        """Whether a run with a step [s] diverges, or loses a nudge. The run is nudged at the
        beginning of the period `index`, and in a second run at the start unless that takes more
        than MOST steps: in a motion that is already disturbed, a nudge may not grow as in the
        motion itself."""
        begins = {index, 0} if self.script.duration <= MOST * step else {index}
        loses_nudge = any(self._nudge_is_lost(method, step, begin) for begin in begins)
        return loses_nudge or math.isinf(self.last_velocity(method, step))

    def lost_along(self, method: str, step: float, index: int) -> bool:
        """Whether nudged runs with a step [s] along the motion are lost. If `index` stands for the
        state of rest beyond the motion, the runs begin at the start and are nudged after MOST
        steps: a nudge of the state of rest may grow although no run reaches that state."""
        if index < len(self.states):
            return self.lost(method, step, index)
        lasting = MOST * step
        grown = self.growth(method, step, self.script.start, 0, lasting, lasting)
        return grown > LOST_GROWTH or self.lost(method, step)

    def _nudge_is_lost(self, method: str, step: float, begin: int) -> bool:
        """Whether a nudge at the beginning of the period `begin` grows beyond the growth that is
        allowed."""
        script = self.script
        duration = min(max(script.duration - begin * script.period, LEAST * step), MOST * step)
        moving = begin < len(self.states)
        if moving:
            start = self.states[begin]
        else:
            at_rest = self.state_at(self.points[-1], method, step)
            if at_rest is None:
                return False
            start = at_rest
            duration = MOST * step
        allowed = LOST_GROWTH
        for near_step in step * np.array(NEAR if moving else NEAR[:1]):
            growth_there = self.growth(method, near_step, start, begin, duration)
            if math.isinf(growth_there):
                return True
            if growth_there > allowed == LOST_GROWTH:
                fine = min(step / FINER, self.model.step)
                allowed *= max(1.0, self.growth(method, fine, start, begin, duration))
            if growth_there <= allowed:
                return False
        # A nudge may decide on which foot a body lands, and nothing after the landing.
        if not moving:
            return True
        return self.growth(method, step, start, begin, duration, MOST * step) > LATER_GROWTH

    @quiet()
    def growth(
        self,
        method: str,
        step: float,
        start: Array,
        begin: int,
        duration: float,
        after: float = 0.0,
    ) -> float:
        """Returns the largest ratio of the difference of two runs with a step [s] to the nudge
        between them, within a `duration` [s], under the controls from the period `begin` on. The
        nudge is made at `start`, or at the state that a run from `start` reaches `after` a time
        [s]. Infinite if a run diverges."""
        runs = self._nudged_runs(method, step)
        nudged = math.ceil(after / step)
        controls = self._controls(begin, step, nudged + math.ceil(duration / step))
        if nudged:
            states = runs.states(start, controls[:nudged])
            if states is None:
                return math.inf
            start = states[-1]
        return runs.growth(start, controls[nudged:])

    @quiet()
    def last_velocity(self, method: str, step: float, duration: float | None = None) -> float:
        """Returns the largest velocity [m/s, rad/s] at the end of a run from the start with a step
        [s]; infinite if the run diverges."""
        controls = self._controls(0, step, math.ceil((duration or MOST * step) / step))
        return self._nudged_runs(method, step).last_velocity(self.script.start, controls)

    def _nudged_runs(self, method: str, step: float) -> NudgedRuns:
        """Runs of a method at a step [s], to be nudged."""
        return NudgedRuns(self.steppers.stepper(method, step), self.space, self.ends)

    def _controls(self, begin: int, step: float, count: int) -> Array:
        """Returns the controls of `count` steps [s] from the period `begin` on, shape (count,
        actuators). The last control is held after the end."""
        periods = (begin + (np.arange(count) + 1e-6) * step / self.script.period).astype(int)
        last = len(self.script.controls) - 1
        return np.asarray(self.script.controls[np.minimum(periods, last)])


def magnifies(motion: AuditedMotion, point: Point, method: str, step: float) -> bool:
    """Whether a step [s] magnifies nudges at a point. The factor must not depend on the size of the
    differences of the Jacobian by more than ALIKE."""
    state = motion.state_at(point, method, step)
    if state is None:
        return False
    factor = motion.excess_from(state, point, method, step)
    if factor <= 1.0 + MARGIN:
        return False
    other = motion.excess_from(state, point, method, step, JACOBIAN_DIFFERENCES[1])
    return math.isinf(min(factor, other)) or max(factor, other) <= ALIKE * min(factor, other)


def predicted_limit(
    motion: AuditedMotion, point: Point, method: str, most: float
) -> float | None:
    """Returns the largest step [s] that holds by the Jacobian at a point; None if all steps up to
    `most` hold. Steps double up to `most`, and the gap before the first step that fails is
    bisected."""

    def holds(step: float) -> bool:
        return not magnifies(motion, point, method, step)

    def middle(held: float, failed: float) -> float | None:
        return (held + failed) / 2.0 if failed - held > RESOLVED * failed else None

    fastest = float(np.abs(point.rates).max())
    safe = SAFE / fastest if fastest else math.inf
    held = 0.0
    failed = min(most / BEYOND if point.rests else safe, most)
    while holds(failed):
        if failed >= most:
            return None
        held = failed
        failed = min(RATIO * failed, most)
    return bisected(holds, held, failed, middle)[0]


def limit_of_method(motion: AuditedMotion, method: str) -> Limit:
    """Returns the limit of a method: the lowest of the limits at points above which a nudged run is
    lost. If nudged runs hold above the limit at a point, the motion leaves that point before a
    nudge has grown."""
    most = BEYOND * motion.model.step
    remark = ""
    predicted = (
        (predicted_limit(motion, point, method, most), point.index) for point in motion.points
    )
    for step, index in sorted((step, index) for step, index in predicted if step):
        if not motion.lost(method, ABOVE * step, index):
            remark = f"; at {index * motion.script.period:.3g} s a nudge grows from "
            remark += f"{1e3 * step:.3g} ms on, for a moment"
            continue
        limit = Limit(method, step, step, index=index)
        if motion.lost(method, BELOW * step, index):
            return limit_by_runs(motion, limit, f"{1e3 * step:.3g} ms by its Jacobians")
        return check_above(motion, replace(limit, first=name_of_first(motion, limit)), {index})
    limit = Limit(method, most)
    if motion.lost(method, most):
        return limit_by_runs(motion, limit, f"none by its Jacobians{remark}")
    return Limit(method, None, confirmed=True, why=f"beyond {BEYOND:g} x its own step{remark}")


def limit_by_runs(motion: AuditedMotion, limit: Limit, why: str) -> Limit:
    """Returns a limit by runs alone, below a step at which runs are lost: the first of falling
    steps at which nudged runs hold and runs at neighbouring steps do not diverge."""
    assert limit.largest_step is not None
    method = limit.integrator
    index = limit.index
    step = limit.largest_step
    while motion.lost(method, step, index) or any(
        math.isinf(motion.last_velocity(method, factor * step)) for factor in NEAR[1:]
    ):
        step /= SPREAD
        if step < limit.largest_step / MOST:
            return replace(limit, why="runs are lost at any step that was tried")
    factors = [motion.excess_at(point, method, ABOVE * step) for point in motion.points]
    worst = motion.points[int(np.argmax(factors))].index
    limit = replace(limit, largest_step=step, why=f"by nudged runs; {why}", index=worst)
    limit = replace(limit, first=name_of_first(motion, limit))
    return check_above(motion, limit, {index, worst})


def check_above(motion: AuditedMotion, limit: Limit, begins: set[int]) -> Limit:
    """Returns the limit, confirmed if runs along the motion that are nudged at one of the periods
    `begins` are lost at ABOVE times the limit. If all of them hold, the limit comes with the
    largest step that was tried."""
    assert limit.largest_step is not None
    holds_to = None
    step = ABOVE * limit.largest_step
    while not any(motion.lost_along(limit.integrator, step, begin) for begin in begins):
        holds_to = step
        step *= SPREAD
        if step > BEYOND * motion.model.step:
            break
    return replace(limit, confirmed=holds_to is None, holds_to=holds_to)


def check_below(motion: AuditedMotion, limit: Limit) -> Limit:
    """Returns a limit after runs from the start at steps spread below it. If one of the runs
    diverges, the limit is lowered. If larger steps do not come to rest and smaller steps do,
    `chatters` is the smallest of the larger steps."""
    if not limit.confirmed:
        return limit
    method = limit.integrator
    most = limit.largest_step or BEYOND * motion.model.step
    steps = np.geomspace(most / RATIO, most, BETWEEN)[:-1]
    velocities = np.array([motion.last_velocity(method, step, MOST * most) for step in steps])
    if np.isinf(velocities).any():
        lost = replace(limit, largest_step=float(steps[int(np.argmax(velocities))]))
        return limit_by_runs(motion, lost, f"{1e3 * most:.3g} ms by its Jacobians")
    first = int(np.argmax(velocities > SETTLED))
    return replace(limit, chatters=float(steps[first])) if first else limit


@dataclass(frozen=True)
class UnstableMode:
    """A mode of a step that grows beyond its partner among the modes of the continuous motion."""

    factor: complex  # factor by which it grows in a step
    right: Array  # right eigenvector, complex, shape (m,)
    dual: Array  # left eigenvector, complex, scaled so that its product with `right` is 1


@np.errstate(over="ignore")
def first_unstable_mode(jacobian: Array, rates: Array, step: float) -> UnstableMode | None:
    """Returns the first mode of a step [s], by magnitude, that exceeds its partner of the
    continuous motion; None if none does. `jacobian` is the derivative of the step, shape (m, m);
    `rates` [1/s] are those of the continuous modes, shape (m,)."""
    from scipy import linalg

    if not np.isfinite(jacobian).all():
        return None
    decomposed: Any = linalg.eig(jacobian, left=True)
    factors, left, right = decomposed
    order = np.argsort(-np.abs(factors))
    partners = np.exp(-np.sort(-rates.real) * step)
    exceeding = np.abs(factors[order]) > (1.0 + MARGIN) * np.maximum(partners, 1.0)
    if not exceeding.any():
        return None
    mode_index = order[int(np.argmax(exceeding))]
    mode = right[:, mode_index]
    conjugate = left[:, mode_index].conj()
    return UnstableMode(factors[mode_index], mode, conjugate / (conjugate @ mode))


@np.errstate(over="ignore")
def first_unstable_part(motion: AuditedMotion, limit: Limit) -> tuple[Place, Element | None]:
    """Returns the place that takes part most in the mode that becomes unstable first, and the
    element there that contributes most to the mode; None if the contributions hardly differ.

    The mode is taken a little beyond the limit, at the state that sets the limit. The contribution
    of an element is the change of the growth of the mode, to first order, when the element is
    weakened.
    """
    assert limit.largest_step is not None
    method = limit.integrator
    step = ABOVE * limit.largest_step
    point = next(point for point in motion.points if point.index == limit.index)
    state = motion.state_at(point, method, step)
    if state is None:
        state = point.state
    jacobian = motion.jacobian(point, state, method, step)
    mode = first_unstable_mode(jacobian, point.rates, step)
    if mode is None:
        return Place(""), None
    weights = np.abs(mode.dual * mode.right)  # participation, independent of units
    place = motion.model.place(state, point.control, weights)
    along = np.stack([mode.right.real, mode.right.imag], axis=1)
    strongest: tuple[float, Element | None] = (NOTICED, None)
    for element in place.elements:
        weakened = motion.changed(element.weaker)
        weaker = weakened.jacobian(point, state, method, step, directions=along)
        changes = mode.dual @ (weaker - jacobian @ along)  # along the two parts of the mode
        change = changes @ np.array([1.0, 1.0j]) / mode.factor
        strongest = max(strongest, (-float(change.real), element), key=lambda entry: entry[0])
    return place, strongest[1]


def name_of_first(motion: AuditedMotion, limit: Limit) -> str:
    """Names the place and the element that become unstable first beyond a limit; empty if they are
    not known."""
    place, element = first_unstable_part(motion, limit)
    return f"{place.name}, {element.name}" if element else place.name


def find_remedies(motion: AuditedMotion, limits: Sequence[Limit]) -> tuple[Remedy, ...]:
    """Returns changes that raise the limit of the first method, the best first. The displacement of
    bodies by a change is measured by runs with small steps of MuJoCo's most stable integrator, as
    far as the motion is known. A change is no remedy if it leaves the limit at the state that sets
    it: other joints may be as stiff."""
    limit_before = limits[0]
    place, element = first_unstable_part(motion, limit_before)
    changes = [*place.remedies, *([element.remedy] if element and element.remedy else [])]
    integrator = motion.model.integrator
    if motion.built is None:
        integrator = max(limits, key=lambda limit: limit.reach).integrator
    states = motion.finely_stepped(integrator)
    remedies = list[Remedy]()
    for change in changes:
        changed = motion.changed(change)
        with suppress(Unsupported):  # an engine may not express the change
            limit = raised_limit(changed, limit_before)
            if limit is not None:
                displacement = largest_displacement(
                    motion.model, states, changed.finely_stepped(integrator)
                )
                remedies.append(Remedy(change, limit, displacement))
    return tuple(sorted(remedies, key=lambda r: r.limit.reach, reverse=True))


def raised_limit(changed: AuditedMotion, own: Limit) -> Limit | None:
    """Returns the limit of a changed model with the method of `own`, the limit of the model itself;
    None unless it is clearly larger."""
    method = own.integrator
    clearly = RAISED * min(own.predicted or math.inf, own.largest_step or math.inf)
    if magnifies(changed, changed.point(own.index), method, clearly):
        return None
    limit = check_below(changed, limit_of_method(changed, method))
    return limit if limit.reach > HELPS * own.reach else None


def largest_steps(
    model: OwnModel,
    script: Script,
    states: Array,
    allowance: Allowance,
    built: BuiltSteppers | None = None,
) -> LargestSteps:
    """Returns the largest steps of all of MuJoCo's integrators, the model's own first, or of the
    engine that `built` the model, along the motion of `script`, and remedies for the first.
    `states` are known at the ends of the periods, shape (k, n). Later limits and remedies are
    computed as far as time allows; after PATIENCE times the time allowed, the search ends."""
    ends = time.process_time() + PATIENCE * allowance.seconds
    motion = AuditedMotion(model, script, states, built, ends)
    methods = model.steppable if built is None else (built.builds.method,)
    limits = [Limit(name, None, why=OUT_OF_TIME) for name in methods]
    remedies: tuple[Remedy, ...] = ()
    with suppress(NotCertifiable):  # raised when the time ends
        limits[0] = check_below(motion, limit_of_method(motion, methods[0]))
        for k, name in enumerate(methods[1:], 1):
            if allowance.left > 0.0:
                limits[k] = limit_of_method(motion, name)
        confirmed = limits[0].largest_step is not None and limits[0].holds_to is None
        if confirmed and allowance.left > 0.0:
            remedies = find_remedies(motion, limits)
    return LargestSteps(tuple(limits), remedies, model.step, len(states) == 1)
