"""The largest step that holds along a certified motion, what sets it, and what raises it.

The Jacobian of one step at states along the motion predicts the limit: a nudge grows without bounds
where the step magnifies some mode of it by more than the continuous motion itself does. Modes of
both are matched by the rank of their magnitudes: if any matching has none that exceeds its partner,
that one has none. A limit is confirmed if nudged runs hold below it, also at steps spread below,
and are lost along the motion at ABOVE times it. If they are not lost there, the limit comes with
the largest step at which they hold.
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

from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.reference import moved
from plumbob.engines.own_motion import (
    OUT_OF_TIME,
    Change,
    Element,
    NotCertifiable,
    OwnModel,
    Place,
    Script,
    StepMaps,
)

STATES = 5  # along the motion
BEYOND = 10.0  # times the model's own step: no larger one is tried
# By which a mode may grow in a step beyond the continuous motion's own growth: a nudge a
# thousandfold in 142 steps. RK4 passes it within 1.2 % of where |R(z)| = 1.
MARGIN = 0.05
SAFE = 0.5  # of the shortest time constant: a step at which every method holds
RATIO = 2.0  # from one step that is tried to the next
RESOLVED = 0.02  # to which a limit is bisected
DIFFERENCES = (1e-6, 1e-7)  # [m, rad, ...] of the Jacobians
# A contact that begins within a difference makes a Jacobian that goes as one over it: such a state
# tells nothing, and its multipliers differ by more than this factor.
ALIKE = 1.5
TINY = 2.0**-24  # [s]: a step that is the continuous motion's
BELOW, ABOVE = 0.9, 1.1  # of a limit: where nudged runs hold, and are lost
LOST = 1e3  # a nudge's growth beyond the continuous motion's own
# Of a step: where a body lands may decide what becomes of a nudge. It does so at one step and not
# at another; one that grows at all of these grows at each step.
NEAR = (1.0, 0.99, 1.01)
SPREAD = 1.05  # from one step that runs have below a limit to the next
BETWEEN = 16  # steps over a factor of RATIO: the same
SETTLED = 0.01  # [m/s, rad/s]: a run with less at its end has come to rest
STILL = 10.0  # growth of a nudge much later: less, and the first one only met a landing
FINER = 4  # times, at least: the step, at most the model's own, by which that is measured
LEAST, MOST = 50, 400  # steps of a nudged run
PATIENCE = 2.0  # times the time allowed: the search then ends
FINE = 8  # steps in place of one, for the motion of a model that a remedy changes
HELPS = 1.1  # times the limit: what a remedy is to reach
RAISED = 1.05  # times the limit by the Jacobian at the state that sets it, at least
NOTICED = 0.01  # of the growth: what an element changes that sets it


@dataclass(frozen=True)
class Limit:
    """The largest step of an integrator below which every one holds along the motion."""

    integrator: str
    largest_step: float | None  # [s]; None where it lies beyond what was tried
    predicted: float | None = None  # [s] by the step's Jacobian; None where that shows no limit
    first: str = ""  # what goes first: a joint, and the actuator, spring, damper or contact
    confirmed: bool = False  # nudged runs hold below it, and are lost above
    why: str = ""  # it is not known, or not confirmed
    index: int = 0  # of the control period in which it is set
    chatters: float | None = None  # [s]: from there on a motion that comes to rest does not
    # [s] the largest step at which nudged runs along the motion hold; None if the limit is
    # confirmed
    holds_to: float | None = None

    @property
    def reach(self) -> float:
        """The largest step [s] that is known to hold; infinite where it lies beyond those tried, 0
        where nothing is known."""
        if not self.confirmed:
            return 0.0
        return math.inf if self.largest_step is None else self.largest_step


@dataclass(frozen=True)
class Remedy:
    """A change of the model that raises the limit of its own integrator."""

    change: Change
    limit: Limit
    moved: float  # [m] by which some body is elsewhere along the certified motion


@dataclass(frozen=True)
class Stability:
    """The limits of all integrators, the model's own first, and remedies, the best first."""

    limits: tuple[Limit, ...]
    remedies: tuple[Remedy, ...]
    step: float  # [s] the model's own
    start_only: bool = False  # no more of the motion is known

    @property
    def own(self) -> Limit:
        """The limit of the model's own integrator."""
        return self.limits[0]

    @property
    def unstable(self) -> bool:
        """Whether the model's own step is: nudged runs have confirmed it."""
        return self.own.confirmed and self.own.reach < self.step


@dataclass(frozen=True)
class Point:
    """A state of the motion, and the modes of the continuous motion there."""

    index: int  # of the control period
    maps: StepMaps
    rates: Array  # [1/s] complex, shape (n,)
    rests: bool = False  # it stands for the state of rest near by, another at each step

    def maps_at(self, integrator: str, step: float) -> StepMaps | None:
        """The Jacobians there; None where a step has no state of rest."""
        return self.maps.at_rest(integrator, step) if self.rests else self.maps


@np.errstate(over="ignore")
def excess(jacobian: Array, rates: Array, step: float) -> float:
    """The largest factor by which a mode of a step grows beyond its partner among the modes of the
    continuous motion, of these `rates` [1/s], or beyond 1."""
    if not np.isfinite(jacobian).all():
        return math.inf
    stepped = np.sort(np.abs(np.linalg.eigvals(jacobian)))
    flow = np.exp(np.sort(rates.real) * step)
    return float((stepped / np.maximum(flow, 1.0)).max())


def excess_at(
    at: Point, integrator: str, step: float, difference: float = DIFFERENCES[0]
) -> float:
    """That of one step [s] at a state."""
    maps = at.maps_at(integrator, step)
    return excess(maps(integrator, step, difference), at.rates, step) if maps else 1.0


def unstable(at: Point, integrator: str, step: float) -> bool:
    """Whether a step [s] magnifies nudges at a state, by a factor that does not depend on the
    differences."""
    factor = excess_at(at, integrator, step)
    if factor <= 1.0 + MARGIN:
        return False
    other = excess_at(at, integrator, step, DIFFERENCES[1])
    return math.isinf(min(factor, other)) or max(factor, other) <= ALIKE * min(factor, other)


def shown(at: Point, integrator: str, most: float) -> float | None:
    """The largest step [s] that holds by the Jacobian at a state before one that does not, of steps
    that double up to `most`, bisected; None where all hold."""
    fastest = float(np.abs(at.rates).max())
    safe = SAFE / fastest if fastest else math.inf
    holds = 0.0
    fails = min(most / BEYOND if at.rests else safe, most)
    while not unstable(at, integrator, fails):
        if fails >= most:
            return None
        holds = fails
        fails = min(RATIO * fails, most)
    while fails - holds > RESOLVED * fails:
        middle = (holds + fails) / 2.0
        holds, fails = (holds, middle) if unstable(at, integrator, middle) else (middle, fails)
    return holds


@dataclass(frozen=True)
class Course:
    """A model along a certified motion: what the limits of its steps are found on."""

    model: OwnModel
    script: Script
    states: Array  # at the ends of the periods as far as they are known, shape (k, n)

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """States spread over the motion, the first and the last included, and the state of rest
        that it may end in: the contacts of that are another at each step."""
        count = len(self.states)
        chosen = np.unique(np.linspace(0, count - 1, STATES).round().astype(int))
        return tuple(self.point(int(k)) for k in (*chosen, count))

    def point(self, index: int) -> Point:
        """The state at the beginning of a control period, after the last one the state of rest."""
        control = self.script.controls[min(index, len(self.script.controls) - 1)]
        last = len(self.states) - 1
        maps = self.model.step_maps(self.states[min(index, last)], control)
        step = maps(self.model.integrator, TINY, DIFFERENCES[0])
        rates = np.linalg.eigvals(step - np.eye(len(step))) / TINY
        return Point(index, maps, np.asarray(rates), index > last)

    def finely_stepped(self, integrator: str) -> Array:
        """States at the ends of the periods as far as the motion is known, at small steps."""
        parts = FINE * round(self.script.period / self.model.step)
        controls = self.script.controls[: max(1, len(self.states) - 1)]
        return self.model.stepped(
            replace(self.script, controls=controls), integrator, parts
        ).states

    def lost(self, integrator: str, step: float, index: int = 0) -> bool:
        """Whether a run with a step [s] diverges, or loses a nudge: one from a period `index` on,
        or one from the start, unless that takes too many steps. A nudge of a motion that is already
        disturbed may not show what one of the motion itself does."""
        whole = self.script.duration <= MOST * step
        nudges = any(self._lost(integrator, step, k) for k in {index, 0 if whole else index})
        return nudges or math.isinf(self.rate(integrator, step))

    def lost_along(self, integrator: str, step: float, index: int) -> bool:
        """Whether nudged runs with a step [s] along the motion itself are lost. If `index` is that
        of a state of rest beyond the motion, the runs begin at the start and are nudged after MOST
        steps: a nudge of the state of rest may grow although no run comes to that state."""
        if index < len(self.states):
            return self.lost(integrator, step, index)
        lasting = MOST * step
        grown, _ = self.model.followed(self.script, 0, integrator, step, lasting, lasting)
        return grown > LOST or self.lost(integrator, step)

    def _lost(self, integrator: str, step: float, begin: int) -> bool:
        script = self.script
        followed = self.model.followed
        duration = min(max(script.duration - begin * script.period, LEAST * step), MOST * step)
        moving = begin < len(self.states)
        if moving:
            start = self.states[begin]
        elif maps := self.points[-1].maps_at(integrator, step):
            start = maps.state
            duration = MOST * step
        else:
            return False
        begun = replace(script, start=start)
        most = LOST
        for tried in step * np.array(NEAR if moving else NEAR[:1]):
            grown, _ = followed(begun, begin, integrator, tried, duration)
            if math.isinf(grown):
                return True
            if grown > most == LOST:
                fine = min(step / FINER, self.model.step)
                most *= max(1.0, followed(begun, begin, integrator, fine, duration)[0])
            if grown <= most:
                return False
        # A nudge may decide on which foot a body lands, and nothing thereafter.
        if not moving:
            return True
        return followed(begun, begin, integrator, step, duration, MOST * step)[0] > STILL

    def rate(self, integrator: str, step: float, duration: float | None = None) -> float:
        """The largest velocity at the end of a run from the start with a step [s]."""
        lasting = duration or MOST * step
        return self.model.followed(self.script, 0, integrator, step, lasting, runs=1)[1]


def limited(course: Course, integrator: str) -> Limit:
    """The limit of an integrator: the lowest of those at the states above which a nudged run is
    lost. Others set none: the motion leaves them before a nudge has grown."""
    most = BEYOND * course.model.step
    passed = ""
    limits = [(step, at.index) for at in course.points if (step := shown(at, integrator, most))]
    for step, index in sorted(limits):
        if not course.lost(integrator, ABOVE * step, index):
            passed = f"; at {index * course.script.period:.3g} s a nudge grows from "
            passed += f"{1e3 * step:.3g} ms on, for a moment"
            continue
        limit = Limit(integrator, step, step, index=index)
        if course.lost(integrator, BELOW * step, index):
            return measured(course, limit, f"{1e3 * step:.3g} ms by its Jacobians")
        return checked_above(course, replace(limit, first=named(course, limit)), {index})
    limit = Limit(integrator, most)
    if course.lost(integrator, most):
        return measured(course, limit, f"none by its Jacobians{passed}")
    return Limit(
        integrator, None, confirmed=True, why=f"beyond {BEYOND:g} x its own step{passed}"
    )


def measured(course: Course, limit: Limit, why: str) -> Limit:
    """A limit by runs alone, below a step at which they are lost: the first of smaller steps at
    which nudged runs hold, and runs at its neighbours do."""
    assert limit.largest_step is not None
    of = limit.integrator
    index = limit.index
    step = limit.largest_step
    while course.lost(of, step, index) or any(
        math.isinf(course.rate(of, n * step)) for n in NEAR[1:]
    ):
        step /= SPREAD
        if step < limit.largest_step / MOST:
            return replace(limit, why="runs are lost at any step that was tried")
    factors = [excess_at(at, of, ABOVE * step) for at in course.points]
    worst = course.points[int(np.argmax(factors))].index
    limit = replace(limit, largest_step=step, why=f"by nudged runs; {why}", index=worst)
    limit = replace(limit, first=named(course, limit))
    return checked_above(course, limit, {index, worst})


def checked_above(course: Course, limit: Limit, begins: set[int]) -> Limit:
    """The limit, confirmed if runs along the motion that are nudged at one of the periods `begins`
    are lost at ABOVE times it; else with the largest step tried at which all of them hold."""
    assert limit.largest_step is not None
    holds_to = None
    step = ABOVE * limit.largest_step
    while not any(course.lost_along(limit.integrator, step, begin) for begin in begins):
        holds_to = step
        step *= SPREAD
        if step > BEYOND * course.model.step:
            break
    return replace(limit, confirmed=holds_to is None, holds_to=holds_to)


def tried_below(course: Course, limit: Limit) -> Limit:
    """A limit with what runs from the start do at steps spread below it: one that diverges lowers
    it; from where they chatter, if smaller steps come to rest, it says."""
    if not limit.confirmed:
        return limit
    of = limit.integrator
    most = limit.largest_step or BEYOND * course.model.step
    tried = np.geomspace(most / RATIO, most, BETWEEN)[:-1]
    rates = np.array([course.rate(of, step, MOST * most) for step in tried])
    if np.isinf(rates).any():
        lost = replace(limit, largest_step=float(tried[int(np.argmax(rates))]))
        return measured(course, lost, f"{1e3 * most:.3g} ms by its Jacobians")
    first = int(np.argmax(rates > SETTLED))
    return replace(limit, chatters=float(tried[first])) if first else limit


@np.errstate(over="ignore")
def culprit(course: Course, limit: Limit) -> tuple[Place, Element | None]:
    """The place that takes part most in the first mode, by magnitude, that exceeds its partner of
    the continuous motion a little beyond a limit, at the state that sets it; and of the elements
    there the one without a part of which that mode grows least, to first order, none where that
    hardly differs."""
    from scipy import linalg

    assert limit.largest_step is not None
    integrator = limit.integrator
    step = ABOVE * limit.largest_step
    at = next(at for at in course.points if at.index == limit.index)
    maps = at.maps_at(integrator, step) or at.maps
    jacobian = maps(integrator, step, DIFFERENCES[0])
    if not np.isfinite(jacobian).all():
        return Place(""), None
    decomposed: Any = linalg.eig(jacobian, left=True)
    factors, left, right = decomposed
    order = np.argsort(-np.abs(factors))
    partners = np.exp(-np.sort(-at.rates.real) * step)
    exceeding = np.abs(factors[order]) > (1.0 + MARGIN) * np.maximum(partners, 1.0)
    if not exceeding.any():
        return Place(""), None
    k = order[int(np.argmax(exceeding))]
    mode = right[:, k]
    dual = left[:, k].conj() / (left[:, k].conj() @ right[:, k])
    place = maps.place(np.abs(dual * mode))  # what takes part, whatever units it has
    along = np.stack([mode.real, mode.imag], axis=1)
    best: tuple[float, Element | None] = (NOTICED, None)
    for element in place.elements:
        weaker = maps.changed(element.weaker)(integrator, step, DIFFERENCES[0], along)
        change = dual @ (weaker - jacobian @ along) @ np.array([1.0, 1.0j]) / factors[k]
        best = max(best, (-float(change.real), element), key=lambda entry: entry[0])
    return place, best[1]


def named(course: Course, limit: Limit) -> str:
    """Names of what goes first beyond a limit; empty where that is not known."""
    place, element = culprit(course, limit)
    return f"{place.name}, {element.name}" if element else place.name


def remedied(course: Course, limits: Sequence[Limit]) -> tuple[Remedy, ...]:
    """Changes that raise the limit of the model's own integrator, tried: the best first. How far
    they move some body is that of runs with small steps of the steadiest integrator, as far as the
    motion is known. A change that leaves the limit at the state that sets it is none: others like
    that joint may be as stiff."""
    own = limits[0]
    place, element = culprit(course, own)
    changes = [*place.remedies, *([element.remedy] if element and element.remedy else [])]
    best = max(limits, key=lambda limit: limit.reach).integrator
    remedies = list[Remedy]()
    states = course.finely_stepped(best)
    there = RAISED * min(own.predicted or math.inf, own.largest_step or math.inf)
    for change in changes:
        other = replace(course, model=course.model.changed((change,)))
        if unstable(other.point(own.index), own.integrator, there):
            continue
        limit = tried_below(other, limited(other, own.integrator))
        if limit.reach > HELPS * own.reach:
            apart = moved(course.model, states, other.finely_stepped(best))
            remedies.append(Remedy(change, limit, apart))
    return tuple(sorted(remedies, key=lambda r: r.limit.reach, reverse=True))


def stability(
    model: OwnModel,
    script: Script,
    states: Array,
    allowance: Allowance,
) -> Stability:
    """The largest steps of all integrators along the motion of `script`, of which `states` at the
    ends of the periods are known, and what raises the model's own; others than that one, and
    remedies, as far as time allows. After PATIENCE times the time allowed the search ends."""
    ends = time.process_time() + PATIENCE * allowance.seconds
    course = Course(replace(model, ends=ends), script, states)
    limits = [Limit(name, None, why=OUT_OF_TIME) for name in model.steppable]
    remedies: tuple[Remedy, ...] = ()
    with suppress(NotCertifiable):  # raised when the time ends
        limits[0] = tried_below(course, limited(course, model.integrator))
        for k, name in enumerate(model.steppable[1:], 1):
            if allowance.left > 0.0:
                limits[k] = limited(course, name)
        confirmed = limits[0].largest_step is not None and limits[0].holds_to is None
        if confirmed and allowance.left > 0.0:
            remedies = remedied(course, limits)
    return Stability(tuple(limits), remedies, model.step, len(states) == 1)
