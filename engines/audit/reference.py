"""A certified reference of a model's continuous motion: adaptive integration, confirmed by another.

Smooth motions, with a contact or a limit now and then, are integrated by an explicit pair of order
8 whose step rejection finds each event, and again by one of order 5 at another tolerance. Where a
contact chatters (a foot slides at its touch threshold), f is discontinuous along the motion and
integration would crawl: contacts then set in over a thin layer, and the motion is computed for
widths that shrink. What two of these differ by, with no discount, is the certificate.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.own_motion import Course, Field, NotCertifiable, OwnModel, Script, Undecided

TIGHT, LOOSE = 1e-10, 1e-8  # relative and absolute tolerances of the two smooth methods
WIDTHS = (1e-5, 1e-6, 3e-7)  # [m] of the layer
IN_LAYER, OTHER_IN_LAYER = 1e-7, 1e-6  # tolerances there
CHATTER, WITHIN = 20, 0.05  # events, within [s]: more are chatter
FINER = 1e-2  # times both tolerances, where those do not resolve the step's error
RESOLVED = 5.0  # times the reference's uncertainty: an error from there on is quoted
REFINING = 0.1  # of the budget, at most; a finer pair takes up to 2.5 times as long
Clock = Callable[[], float]


@dataclass(frozen=True)
class Reference:
    """The continuous motion at the ends of the control periods, and how well it is known."""

    course: Course
    confirmed_by: Course | None
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
    model: OwnModel, script: Script, budget: float, clock: Clock = time.perf_counter
) -> Reference:
    """The reference of `model` under `script`, computed within about `budget` [s] of wall time.
    Where nothing can be certified, its uncertainty is infinite after the start and `why` says so.
    """
    ends = clock() + budget
    first = integrated(model.field(), script, "DOP853", TIGHT, clock() + 0.4 * budget, clock)
    if not first.why:
        second = integrated(model.field(), script, "RK45", LOOSE, ends, clock)
        return _compared(model, first, second, ())
    courses: list[Course] = []
    layers_ended = ""
    for done, width in enumerate(WIDTHS if first.decided else ()):
        until = clock() + (ends - clock()) / (len(WIDTHS) + 1 - done)
        found = integrated(model.field(width), script, "RK45", IN_LAYER, until, clock, many=True)
        layers_ended = layers_ended or found.why
        if found.until <= 0.0:
            break
        courses.append(replace(found, how=f"{found.how}, contacts over {width:g} m"))
    layered = None
    if len(courses) > 1:
        layered = _compared(model, courses[-1], courses[-2], WIDTHS[: len(courses)])
        # Where no contact is met within the layers, both widths give the same bits.
        field = model.field(WIDTHS[len(courses) - 1])
        again = integrated(field, script, "RK45", OTHER_IN_LAYER, ends, clock, many=True)
        layered = _at_most(layered, _compared(model, courses[-1], again, layered.widths))
    # What came before the chatter may be known better, and longer.
    smooth = None
    if first.until > 0.0:
        second = integrated(model.field(), _up_to(script, first.until), "RK45", LOOSE, ends, clock)
        smooth = _compared(model, first, _lengthened(second, first), ())
    known = [r for r in (layered, smooth) if r is not None and r.until > 0.0]
    after = f"; with contacts over a layer, {layers_ended}" if layers_ended else ""
    if not known:
        return _none(model, script, replace(first, why=first.why + after))
    best = max(known, key=lambda r: r.until)
    if layered is not None and smooth is not None and best is layered:
        best = _joined(smooth, layered)
    best = replace(best, not_smooth=first.why if best.widths else "")
    if best.until >= script.duration * (1 - 1e-9):
        return best
    return replace(best, why=best.why if best.widths else first.why + after)


def refined(
    model: OwnModel,
    script: Script,
    reference: Reference,
    error: float,
    budget: float,
    clock: Clock = time.perf_counter,
) -> Reference:
    """The reference of a smooth motion at finer tolerances, where it is not known to a fifth of the
    step's `error` [m] and a part of `budget` [s] suffices; else as it was."""
    other, index = reference.confirmed_by, len(script.controls)
    if reference.widths or reference.why or other is None:
        return reference
    if RESOLVED * reference.uncertainty[index] < error or not error > reference.rounding:
        return reference
    if 2.5 * (reference.course.seconds + other.seconds) > REFINING * budget:
        return reference
    ends = clock() + REFINING * budget
    first = integrated(model.field(), script, "DOP853", FINER * TIGHT, ends, clock)
    second = integrated(model.field(), script, "RK45", FINER * LOOSE, ends, clock)
    if first.why or second.why:
        return reference
    finer = _compared(model, first, second, ())
    return finer if finer.uncertainty[index] < reference.uncertainty[index] else reference


def integrated(
    field: Field,
    script: Script,
    method: str,
    tolerance: float,
    ends: float,
    clock: Clock,
    many: bool = False,
) -> Course:
    """The motion by an adaptive `method` of scipy's, begun anew with each control period; it gives
    up at `ends` by `clock`, where the step collapses, and, unless `many` are allowed, where events
    come too often."""
    from scipy import integrate

    solver: Any = getattr(integrate, method)
    states = np.full((len(script.controls) + 1, script.start.size), np.nan)
    states[0] = y = field.normalised(script.start)
    begin, events = clock(), list[float]()
    size: float | None = None
    before: bytes | None = None
    how, why, done, decided = f"{method} at {tolerance:g}", "", 0, True
    try:
        for k, control in enumerate(script.controls):
            field.hold(control)
            start, end = k * script.period, (k + 1) * script.period
            first = min(size, 0.999 * (end - start)) if size else None
            run = solver(
                field, start, y, end, rtol=tolerance, atol=tolerance, first_step=first,
                max_step=script.period,
            )  # fmt: skip
            while run.status == "running":
                run.step()
                if run.status == "failed":
                    raise NotCertifiable(f"the step collapses at {run.t:.6g} s")
                if run.t < end:
                    size = run.h_abs
                if (acting := field.active()) != before:
                    events += [run.t] if before is not None else []
                    before = acting
                if not many and _chatters(events):
                    raise NotCertifiable(f"contacts chatter from {events[-CHATTER - 1]:.4g} s on")
                if clock() > ends:
                    raise NotCertifiable(f"the time given for it ended at {run.t:.4g} s")
            y = field.normalised(run.y)
            if not np.isfinite(y).all():
                raise NotCertifiable(f"the motion has no bounds from {end:.4g} s on")
            states[k + 1], done = y, k + 1
    except NotCertifiable as reason:
        why, decided = str(reason), not isinstance(reason, Undecided)
    return Course(
        states, done * script.period, how, field.evaluations, tuple(events), why, decided,
        clock() - begin,
    )  # fmt: skip


def _chatters(events: list[float]) -> bool:
    return len(events) > CHATTER and events[-1] - events[-CHATTER - 1] < WITHIN


def _compared(model: OwnModel, best: Course, other: Course, widths: tuple[float, ...]) -> Reference:
    """A reference from two computations: how far they are apart is its uncertainty."""
    here, there = model.positions(best.states), model.positions(other.states)
    apart = largest(np.linalg.norm(here - there, axis=2))
    rounding = np.finfo(float).eps * largest(np.abs(here).max(axis=2))
    apart[1:] = np.maximum(apart, rounding)[1:]
    coordinates = largest(np.abs(model.coordinates(best.states, other.states)))
    why = best.why or other.why
    return Reference(best, other, apart, coordinates, here, widths, why)


def _joined(first: Reference, then: Reference) -> Reference:
    """The first reference as far as it is the better known, then the second."""
    better = np.flatnonzero(first.uncertainty <= then.uncertainty)
    count = int(better[-1]) + 1
    assert first.confirmed_by is not None
    assert then.confirmed_by is not None

    def course(one: Course, other: Course) -> Course:
        return replace(other, states=np.concatenate([one.states[:count], other.states[count:]]))

    def known(one: Array, other: Array) -> Array:
        return np.asarray(np.maximum.accumulate(np.concatenate([one[:count], other[count:]])))

    return replace(
        then,
        course=course(first.course, then.course),
        confirmed_by=course(first.confirmed_by, then.confirmed_by),
        uncertainty=known(first.uncertainty, then.uncertainty),
        uncertainty_coordinates=known(first.uncertainty_coordinates, then.uncertainty_coordinates),
        positions=np.concatenate([first.positions[:count], then.positions[count:]]),
    )


def _at_most(one: Reference, other: Reference) -> Reference:
    """The first of two comparisons, with the larger uncertainty of both."""
    return replace(
        one,
        uncertainty=np.maximum(one.uncertainty, other.uncertainty),
        uncertainty_coordinates=np.maximum(
            one.uncertainty_coordinates, other.uncertainty_coordinates
        ),
        why=one.why or other.why,
    )


def largest(values: Array) -> Array:
    """The largest of each row so far, infinite from the first row on that is no number; values of
    shape (n, m)."""
    worst = np.where(np.isfinite(values).all(axis=1), values.max(axis=1, initial=0.0), math.inf)
    return np.asarray(np.maximum.accumulate(worst))


def _none(model: OwnModel, script: Script, first: Course) -> Reference:
    unknown = np.full(len(script.controls) + 1, math.inf)
    unknown[0] = 0.0
    return Reference(first, None, unknown, unknown, model.positions(first.states), (), first.why)


def _up_to(script: Script, until: float) -> Script:
    count = round(until / script.period)
    return replace(script, controls=script.controls[:count])


def _lengthened(course: Course, like: Course) -> Course:
    """A course padded with unknown states to as many as another has."""
    states = np.full_like(like.states, np.nan)
    states[: len(course.states)] = course.states
    return replace(course, states=states)
