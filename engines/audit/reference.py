"""A certified reference of a model's continuous motion: adaptive integration, confirmed by another.

Smooth motions, with a contact or a limit now and then, are integrated by an explicit pair of order
8 whose step rejection finds each event, and again by one of order 5 at another tolerance. Where a
contact chatters (a foot slides at its touch threshold), f is discontinuous along the motion and
integration would crawl: contacts then set in over a thin layer, and the motion is computed for
widths that shrink. What two computations differ by, with no discount, is the certificate; of layers
it is how far their limit is from the narrowest.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.own_motion import (
    Field,
    Integration,
    NotCertifiable,
    OwnModel,
    Script,
    Undecided,
)

TIGHT, LOOSE = 1e-10, 1e-8  # relative and absolute tolerances of the two smooth methods
WIDTHS = (1e-5, 1e-6, 3e-7)  # [m] of the layer
IN_LAYER, OTHER_IN_LAYER = 1e-7, 1e-6  # tolerances there
# Powers of a layer's width that its distance from the limit goes as. A touch at a speed is felt for
# a time that goes as the width, one that grazes as its root, and one whose acceleration and jerk
# vanish too as its fourth root; the smallest power outlasts the others as layers shrink.
POWERS = (0.25, 0.5)
CHATTER, WITHIN = 20, 0.05  # events, within [s]: more are chatter
FIRST, PARTS = 0.4, 3  # of the budget, for the first method; a third of the rest confirms it
FINER = 1e-2  # times both tolerances, where those do not resolve the step's error
RESOLVED = 5.0  # times the reference's uncertainty: an error from there on is quoted
REFINING = 0.1  # of the budget, at most; a finer pair takes up to 2.5 times as long
OUT_OF_TIME = "the time given for it ended"
Clock = Callable[[], float]


@dataclass(frozen=True)
class Run:
    """One computation of the motion."""

    method: str
    tolerance: float
    width: float  # [m] of the layer over which contacts begin; 0: at once
    seconds: float  # that it may take


@dataclass(frozen=True)
class Certificate:
    """The continuous motion at the ends of the control periods, and how well it is known."""

    course: Integration
    confirmed_by: Integration | None
    uncertainty: Array  # [m] largest distance of any body so far from the confirmation's, (n,)
    uncertainty_coordinates: Array  # [rad or m] the same in generalised coordinates
    positions: Array  # [m] of the bodies, shape (n, bodies, 3)
    widths: tuple[float, ...] = ()  # [m] of the layers; empty for a smooth motion
    why: str = ""  # there is none, or it ends early
    not_smooth: str = ""  # why layers were needed

    @property
    def rounding(self) -> float:
        """[m] of the bodies' positions."""
        return float(np.finfo(float).eps * np.abs(self.positions).max())

    @property
    def until(self) -> float:
        """[s] to which both computations reach."""
        return min(self.course.until, self.confirmed_by.until if self.confirmed_by else 0.0)


def certified(
    model: OwnModel,
    script: Script,
    budget: float,
    clock: Clock = time.process_time,
    executor: Executor | None = None,
) -> Certificate:
    """The reference of `model` under `script`, computed within about `budget` [s] of processor
    time; its confirmation runs beside it in an `executor` of two processes or more, if given, with
    the same bits. Where nothing can be certified, its uncertainty is infinite after the start and
    `why` says so."""
    ends = clock() + budget
    loose = Run("RK45", LOOSE, 0.0, (1.0 - FIRST) * budget)
    beside = executor.submit(computed, model, script, loose, clock) if executor else None
    first = computed(model, script, Run("DOP853", TIGHT, 0.0, FIRST * budget), clock)
    if not first.why:
        second = computed(model, script, loose, clock) if beside is None else beside.result()
        return _compared(model, first, second, ())
    # What came before the chatter may be known better, and longer.
    smooth = None
    if beside is not None:
        second = beside.result()
    elif first.until > 0.0:
        some = replace(loose, seconds=(ends - clock()) / PARTS)
        second = computed(model, _up_to(script, first.until), some, clock)
    if first.until > 0.0:
        smooth = _compared(model, first, _cut(second, script, first.until), ())
    layered, ended = None, ""
    if first.decided:
        layered, ended = _layered(model, script, ends, clock, executor)
    known = [r for r in (layered, smooth) if r is not None and r.until > 0.0]
    after = f"; with contacts over a layer, {ended}" if ended else ""
    if not known:
        return _none(model, script, replace(first, why=first.why + after))
    best = max(known, key=lambda r: r.until)
    if layered is not None and smooth is not None and best is layered:
        best = _joined(smooth, layered)
    best = replace(best, not_smooth=first.why if best.widths else "")
    if best.until >= script.duration * (1 - 1e-9):
        return best
    return replace(best, why=best.why or ended if best.widths else first.why + after)


def _layered(
    model: OwnModel, script: Script, ends: float, clock: Clock, executor: Executor | None
) -> tuple[Certificate | None, str]:
    """The motion with contacts that set in over layers, which shrink, and why one of them ended;
    none where fewer than two are computed."""
    done = _by_width(model, script, ends, clock, executor)
    ended = next((course.why for course in done.values() if course.why), "")
    layers = [(w, done[w, IN_LAYER]) for w in WIDTHS if (w, IN_LAYER) in done]
    layers = [(w, _cut(c, script, script.duration)) for w, c in layers if c.until > 0.0]
    if len(layers) < 2:
        return None, ended
    (_, other), (width, best) = layers[-2:]
    # Where no contact is met within the layers, both widths give the same bits.
    again = done.get((width, OTHER_IN_LAYER))
    if again is None:
        short = _up_to(script, min(best.until, other.until))
        last = Run("RK45", OTHER_IN_LAYER, width, ends - clock())
        again = computed(model, short, last, clock)
    return _in_layers(model, layers, _cut(again, script, script.duration)), ended


def _by_width(
    model: OwnModel, script: Script, ends: float, clock: Clock, executor: Executor | None
) -> dict[tuple[float, float], Integration]:
    """The motion by width of the layer and tolerance, until one of them has no duration."""
    runs = [*((width, IN_LAYER) for width in WIDTHS), (WIDTHS[-1], OTHER_IN_LAYER)]
    pace = 1 if executor is None else 2
    groups = [runs[i : i + pace] for i in range(0, len(runs), pace)]
    done: dict[tuple[float, float], Integration] = {}
    for k, group in enumerate(groups):
        if not all(course.until > 0.0 for course in done.values()):
            break
        seconds = (ends - clock()) / (len(groups) - k)
        # What one of them does not reach is not known: the others need not go on for longer.
        short = _up_to(script, min((c.until for c in done.values()), default=script.duration))
        asked = [Run("RK45", tolerance, width, seconds) for width, tolerance in group]
        courses = _beside(model, short, asked, clock, executor)
        done.update(zip(group, courses, strict=True))
    return done


def _in_layers(
    model: OwnModel, layers: Sequence[tuple[float, Integration]], again: Integration
) -> Certificate:
    """The motion of the last, narrowest, of `layers`; how far it is from the limit and what it
    differs by from `again`, at another tolerance, may add up."""
    widths = tuple(width for width, _ in layers)
    apart = [_compared(model, narrow, wide, widths) for (_, wide), (_, narrow) in pairwise(layers)]
    last, other = apart[-1], _compared(model, layers[-1][1], again, widths)
    coordinates = left_open(widths, [r.uncertainty_coordinates for r in apart])
    return replace(
        last,
        uncertainty=left_open(widths, [r.uncertainty for r in apart]) + other.uncertainty,
        uncertainty_coordinates=coordinates + other.uncertainty_coordinates,
        why=last.why or other.why,
    )


def left_open(widths: Sequence[float], apart: Sequence[Array]) -> Array:
    """How far the motion with the last, narrowest, of `widths` may be from the limit, given how far
    each is `apart` from the next. The power comes from the ratio of two of these, within `POWERS`;
    where two widths alone are known, or differences do not fall as any power's, it is the least.
    Each difference leaves some of the way to the limit open, and one may be small by chance."""
    powers = np.linspace(*POWERS, 101)
    steps = np.array([wide**powers - narrow**powers for wide, narrow in pairwise(widths)])
    power = np.full(apart[-1].shape, POWERS[0])
    if len(apart) > 1:
        with np.errstate(divide="ignore", invalid="ignore"):
            power = np.interp(np.nan_to_num(apart[-2] / apart[-1]), steps[-2] / steps[-1], powers)
    left = [
        difference * widths[-1] ** power / (wide**power - narrow**power)
        for difference, (wide, narrow) in zip(apart, pairwise(widths), strict=True)
    ]
    return np.asarray(np.max(left, axis=0))


def refined(
    model: OwnModel,
    script: Script,
    reference: Certificate,
    error: float,
    budget: float,
    clock: Clock = time.process_time,
    executor: Executor | None = None,
) -> Certificate:
    """The reference of a smooth motion at finer tolerances, where it is not known to a fifth of the
    step's `error` [m] and a part of `budget` [s] suffices; else as it was."""
    other, index = reference.confirmed_by, len(script.controls)
    if reference.widths or reference.why or other is None:
        return reference
    if RESOLVED * reference.uncertainty[index] < error or not error > reference.rounding:
        return reference
    if 2.5 * (reference.course.seconds + other.seconds) > REFINING * budget:
        return reference
    asked = [
        Run(method, FINER * tolerance, 0.0, REFINING * budget)
        for method, tolerance in (("DOP853", TIGHT), ("RK45", LOOSE))
    ]
    first, second = _beside(model, script, asked, clock, executor)
    if first.why or second.why:
        return reference
    finer = _compared(model, first, second, ())
    return finer if finer.uncertainty[index] < reference.uncertainty[index] else reference


def computed(
    model: OwnModel, script: Script, run: Run, clock: Clock = time.process_time
) -> Integration:
    """The motion of `model` under `script` by one method, for as long as it is given."""
    many = run.width > 0.0
    course = integrated(
        model.field(run.width),
        script,
        run.method,
        run.tolerance,
        clock() + run.seconds,
        clock,
        many,
    )
    return replace(course, how=f"{course.how}, contacts over {run.width:g} m") if many else course


def _beside(
    model: OwnModel, script: Script, runs: Sequence[Run], clock: Clock, executor: Executor | None
) -> list[Integration]:
    """Some runs, each in a process of its own where there is an executor."""
    if executor is None:
        return [computed(model, script, run, clock) for run in runs]
    tasks = [executor.submit(computed, model, script, run, clock) for run in runs]
    return [task.result() for task in tasks]


class _Watch:
    """Ends an integration where time runs out and, unless `many` events are allowed, where contacts
    chatter; `events` are the times [s] at which those that act changed."""

    def __init__(self, field: Field, many: bool, clock: Clock, ends: float) -> None:
        self.field, self.many, self.clock, self.ends = field, many, clock, ends
        self.events: list[float] = []
        self.before: bytes | None = None

    def after_step(self, time: float) -> None:
        """Look at the contacts at `time` [s]; raises NotCertifiable."""
        if (acting := self.field.active()) != self.before:
            self.events += [time] if self.before is not None else []
            self.before = acting
        if not self.many and _chatters(self.events):
            raise NotCertifiable(f"contacts chatter from {self.events[-CHATTER - 1]:.4g} s on")
        if self.clock() > self.ends:
            raise NotCertifiable(f"{OUT_OF_TIME} at {time:.4g} s")


def integrated(
    field: Field,
    script: Script,
    method: str,
    tolerance: float,
    ends: float,
    clock: Clock,
    many: bool = False,
) -> Integration:
    """The motion by an adaptive `method` of scipy's, begun anew with each control period; it gives
    up at `ends` by `clock`, where the step collapses, and, unless `many` are allowed, where events
    come too often."""
    from scipy import integrate

    solver: Any = getattr(integrate, method)
    states = np.full((len(script.controls) + 1, script.start.size), np.nan)
    states[0] = y = field.normalised(script.start)
    begin, watch = clock(), _Watch(field, many, clock, ends)
    size: float | None = None
    why, done, decided = "", 0, True
    try:
        for k, control in enumerate(script.controls):
            start, end = k * script.period, (k + 1) * script.period
            field.hold(control, start, y)
            first = min(size, 0.999 * (end - start)) if size else None
            run = solver(
                *(field, start, y, end),
                first_step=first,
                max_step=script.period,
                rtol=tolerance,
                atol=tolerance,
            )
            while run.status == "running":
                run.step()
                if run.status == "failed":
                    raise NotCertifiable(f"the step collapses at {run.t:.6g} s")
                if run.t < end:
                    size = run.h_abs
                watch.after_step(run.t)
            y = field.normalised(run.y)
            if not np.isfinite(y).all():
                raise NotCertifiable(f"the motion has no bounds from {end:.4g} s on")
            states[k + 1], done = y, k + 1
    except NotCertifiable as reason:
        why, decided = str(reason), not isinstance(reason, Undecided)
    return Integration(
        states,
        done * script.period,
        f"{method} at {tolerance:g}",
        field.evaluations,
        tuple(watch.events),
        why,
        decided,
        clock() - begin,
    )


def _chatters(events: list[float]) -> bool:
    return len(events) > CHATTER and events[-1] - events[-CHATTER - 1] < WITHIN


def _compared(
    model: OwnModel, best: Integration, other: Integration, widths: tuple[float, ...]
) -> Certificate:
    """A reference from two computations: how far they are apart is its uncertainty."""
    here = model.positions(best.states)
    apart = distances(here, model.positions(other.states))
    rounding = np.finfo(float).eps * largest(np.abs(here).max(axis=2))
    apart[1:] = np.maximum(apart, rounding)[1:]
    coordinates = largest(np.abs(model.coordinates(best.states, other.states)))
    why = best.why or other.why
    return Certificate(best, other, apart, coordinates, here, widths, why)


def _joined(first: Certificate, then: Certificate) -> Certificate:
    """The first reference as far as it is the better known, then the second."""
    known_first = np.isfinite(first.uncertainty)
    better = np.flatnonzero(known_first & (first.uncertainty <= then.uncertainty))
    count = int(better[-1]) + 1
    assert first.confirmed_by is not None
    assert then.confirmed_by is not None

    def course(before: Integration, after: Integration) -> Integration:
        return replace(after, states=np.concatenate([before.states[:count], after.states[count:]]))

    def known(values: Array, later: Array) -> Array:
        return np.maximum.accumulate(np.concatenate([values[:count], later[count:]]))

    return replace(
        then,
        course=course(first.course, then.course),
        confirmed_by=course(first.confirmed_by, then.confirmed_by),
        uncertainty=known(first.uncertainty, then.uncertainty),
        uncertainty_coordinates=known(first.uncertainty_coordinates, then.uncertainty_coordinates),
        positions=np.concatenate([first.positions[:count], then.positions[count:]]),
    )


def distances(here: Array, there: Array) -> Array:
    """The largest distance [m] of any body so far between two courses of their positions [m], each
    of shape (n, bodies, 3); infinite from where one is no number."""
    return largest(np.linalg.norm(here - there, axis=2))


def moved(model: OwnModel, before: Array, after: Array) -> float:
    """The largest of them between two courses of states, shape (n, k)."""
    return float(distances(model.positions(before), model.positions(after))[-1])


def largest(values: Array) -> Array:
    """The largest of each row so far, infinite from the first row on that is no number; values of
    shape (n, m)."""
    worst = np.where(np.isfinite(values).all(axis=1), values.max(axis=1, initial=0.0), math.inf)
    return np.maximum.accumulate(worst)


def _none(model: OwnModel, script: Script, first: Integration) -> Certificate:
    unknown = np.full(len(script.controls) + 1, math.inf)
    unknown[0] = 0.0
    return Certificate(first, None, unknown, unknown, model.positions(first.states), (), first.why)


def _up_to(script: Script, until: float) -> Script:
    count = round(until / script.period)
    return replace(script, controls=script.controls[:count])


def _cut(course: Integration, script: Script, until: float) -> Integration:
    """A course up to `until` [s], its states as many as the whole of `script` has, unknown beyond
    that."""
    states = np.full((len(script.controls) + 1, script.start.size), np.nan)
    known = min(len(course.states), round(until / script.period) + 1)
    states[:known] = course.states[:known]
    reached = course.until >= until * (1 - 1e-9)
    why = "" if reached else course.why
    return replace(course, states=states, until=min(course.until, until), why=why)
