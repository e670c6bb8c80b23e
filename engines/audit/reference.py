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
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.own_motion import (
    OUT_OF_TIME,
    Integration,
    NotCertifiable,
    OwnModel,
    Script,
)

TIGHT, LOOSE = 1e-10, 1e-8  # relative and absolute tolerances of the two smooth methods
WIDTHS = (1e-5, 1e-6, 3e-7)  # [m] of the layer
IN_LAYER, OTHER_IN_LAYER = 1e-7, 1e-6  # tolerances there
# Powers of a layer's width that its distance from the limit goes as. A touch at a speed is felt for
# a time that goes as the width, one that grazes as its root, and one whose acceleration and jerk
# vanish too as its fourth root; the smallest power outlasts the others as layers shrink.
POWERS = (0.25, 0.5)
CHATTER, WITHIN = 20, 0.05  # events, within [s]: more are chatter
STEPS_IN_TOUCH = 4.0  # at least: some stages then lie in a touch that a larger step passed over
FIRST = 0.4  # of the time, for the first method
RESOLVED = 5.0  # times the reference's uncertainty: an error from there on is quoted
MEASURE = "corner displacement"  # the name in JSON of the measure of errors
NOTHING = 1e-9  # [m]: rounding and solver tolerances leave as much in the steps


@dataclass(frozen=True)
class Certificate:
    """The continuous motion at the ends of the control periods, and how well it is known."""

    course: Integration
    confirmed_by: Integration
    uncertainty: Array  # [m] largest displacement of any corner so far from the other's, (n,)
    corners: Array  # [m] corner points of the bodies, shape (n, corners, 3)
    widths: tuple[float, ...] = ()  # [m] of the layers; empty for a smooth motion
    why: str = ""  # there is none, or it ends early
    not_smooth: str = ""  # why layers were needed

    @property
    def known(self) -> int:
        """Index of the last control period at whose end it is known."""
        return int(np.flatnonzero(np.isfinite(self.uncertainty))[-1])

    @property
    def states(self) -> Array:
        """Those of the motion up to there."""
        return self.course.states[: self.known + 1]

    @property
    def until(self) -> float:
        """[s] to which both computations reach."""
        return min(self.course.until, self.confirmed_by.until)


def certified(model: OwnModel, script: Script, allowance: Allowance) -> Certificate:
    """The reference of `model` under `script`; its confirmation runs beside it in an executor, with
    the same bits. Where nothing can be certified, its uncertainty is infinite after the start and
    `why` says so."""
    return telling(_certified(model, script, allowance))


def telling(reference: Certificate) -> Certificate:
    """The reference up to the last time at which it tells something about the motion: there its
    uncertainty is less than the largest displacement so far, or no more than rounding leaves."""
    moved_by = distances(reference.corners[:1], reference.corners)
    unknown = reference.uncertainty
    last = int(np.flatnonzero((unknown < moved_by) | (unknown <= NOTHING))[-1])
    end = reference.known
    if last >= end:
        return reference
    why = f"known to ±{unknown[end]:.1e} m only, the motion is {moved_by[end]:.2g} m"
    return replace(
        reference,
        uncertainty=np.where(np.arange(len(unknown)) > last, math.inf, unknown),
        why="; ".join(filter(None, (why, reference.why))),
    )


def _certified(model: OwnModel, script: Script, allowance: Allowance) -> Certificate:
    seconds = allowance.seconds
    second = allowance.start(computed, model, script, "RK45", LOOSE, (1.0 - FIRST) * seconds)
    first = computed(model, script, "DOP853", TIGHT, FIRST * seconds)
    smooth = _compared(model, first, second())
    if not first.why:
        return smooth
    layered, ended = _layered(model, script, allowance)
    if layered is not None and layered.until > smooth.until:
        why = "" if layered.until >= script.duration * (1 - 1e-9) else layered.why or ended
        return replace(layered, why=why, not_smooth=first.why)
    after = f"; with contacts over a layer, {ended}" if ended else ""
    return replace(smooth, why=first.why + after)


def uncertain(model: OwnModel, script: Script) -> Certificate:
    """A certificate of the start alone."""
    start = Integration(script.start[None], 0.0)
    return _compared(model, start, start)


def _layered(
    model: OwnModel, script: Script, allowance: Allowance
) -> tuple[Certificate | None, str]:
    """The motion with contacts that set in over layers, which shrink, and why one of them ended;
    none where one has no duration."""
    asked = [*((width, IN_LAYER) for width in WIDTHS), (WIDTHS[-1], OTHER_IN_LAYER)]
    pace = 1 if allowance.executor is None else 2
    courses = list[Integration]()
    while len(courses) < len(asked):
        seconds = allowance.left * pace / (len(asked) - len(courses))
        runs = [
            allowance.start(computed, model, script, "RK45", tolerance, seconds, width)
            for width, tolerance in asked[len(courses) :][:pace]
        ]
        courses += [run() for run in runs]
        if not all(course.until > 0.0 for course in courses):
            return None, next(course.why for course in courses if course.why)
    ended = next((course.why for course in courses if course.why), "")
    return _in_layers(model, courses[:-1], courses[-1]), ended


def _in_layers(
    model: OwnModel, layers: Sequence[Integration], again: Integration
) -> Certificate:
    """The motion of the last, narrowest, of `layers`; how far it is from the limit and what it
    differs by from `again`, at another tolerance, may add up."""
    apart = [_compared(model, narrow, wide) for wide, narrow in pairwise(layers)]
    last = apart[-1]
    other = _compared(model, layers[-1], again)
    return replace(
        last,
        uncertainty=left_open(WIDTHS, [r.uncertainty for r in apart]) + other.uncertainty,
        widths=WIDTHS,
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
            power = np.interp(
                np.nan_to_num(apart[-2] / apart[-1]), steps[-2] / steps[-1], powers
            )
    left = [
        difference * widths[-1] ** power / (wide**power - narrow**power)
        for difference, (wide, narrow) in zip(apart, pairwise(widths), strict=True)
    ]
    return np.asarray(np.max(left, axis=0))


class _Watch:
    """Ends an integration where time runs out and, unless `many` events are allowed, where contacts
    chatter; `events` are the times [s] at which those that act changed."""

    def __init__(self, field: Any, many: bool, seconds: float) -> None:
        self.field, self.many, self.ends = field, many, time.process_time() + seconds
        self.events: list[float] = []
        self.before: bytes | None = None

    def __call__(self, at: float, state: Array) -> Array:
        """Rates of a state `at` a time [s]; raises NotCertifiable."""
        if time.process_time() > self.ends:
            raise NotCertifiable(f"{OUT_OF_TIME} at {at:.4g} s")
        return np.asarray(self.field(at, state))

    def after_step(self, at: float, acting: bytes) -> None:
        """Look at the contacts that act `at` a time [s]; raises NotCertifiable."""
        if acting != self.before:
            self.events += [at] if self.before is not None else []
            self.before = acting
        recent = self.events[-CHATTER - 1 :]
        if not self.many and len(recent) > CHATTER and recent[-1] - recent[0] < WITHIN:
            raise NotCertifiable(f"contacts chatter from {recent[0]:.4g} s on")


@np.errstate(all="ignore")  # a motion without bounds is refused below
def computed(
    model: OwnModel,
    script: Script,
    method: str,
    tolerance: float,
    seconds: float,
    width: float = 0.0,
) -> Integration:
    """The motion of `model` under `script` by an adaptive method of scipy's, begun anew with each
    control period; contacts begin over a layer of this `width` [m], or at once. It gives up where
    its time ends, where the step collapses and, without a layer, where events come too often."""
    field = model.field(width)
    watch = _Watch(field, width > 0.0, seconds)
    touches = model.hidden_touches(field, script.start)
    integrator = _Integrator(method, watch, tolerance, touches)
    states = np.full((len(script.controls) + 1, script.start.size), np.nan)
    states[0] = y = field.normalised(script.start)
    done, why = 0, ""
    try:
        for k, control in enumerate(script.controls):
            start = k * script.period
            end = (k + 1) * script.period
            field.hold(control, start, y)
            y = field.normalised(integrator.through(start, y, end, script.period))
            if not np.isfinite(y).all():
                raise NotCertifiable(f"the motion has no bounds from {end:.4g} s on")
            states[k + 1] = y
            done = k + 1
    except NotCertifiable as reason:
        why = str(reason)
    return Integration(
        states,
        done * script.period,
        tuple(watch.events),
        why,
    )


class _Integrator:
    """One of scipy's adaptive methods along a field; each step is searched for hidden touches."""

    def __init__(self, method: str, watch: _Watch, tolerance: float, touches: Any) -> None:
        from scipy import integrate

        self.begun = partial(getattr(integrate, method), watch, rtol=tolerance, atol=tolerance)
        self.watch, self.touches = watch, touches
        # [s] of the next step, by the last one that the end of its interval did not shorten
        self.size: float | None = None

    def through(self, start: float, y: Array, end: float, most: float) -> Array:
        """The state at `end` [s] of the motion from the state `y` at `start` [s], by steps of
        `most` [s] at most. If a step passes over a touch, three runs replace it: up to the touch,
        through the touch by a few steps, and on to the `end`."""
        size = min(self.size, 0.999 * (end - start)) if self.size else None
        motion = self.begun(start, y, end, first_step=size, max_step=most)
        while motion.status == "running":
            before, y = motion.t, motion.y
            motion.step()
            if motion.status == "failed":
                raise NotCertifiable(f"the step collapses at {motion.t:.6g} s")
            acting = self.watch.field.active()
            touch = self.touches.within(motion.t, motion.dense_output)
            if touch is not None:
                y = self.through(before, y, touch.begins, most)
                if (lasts := touch.ends - touch.begins) > 0.0:
                    y = self.through(touch.begins, y, touch.ends, lasts / STEPS_IN_TOUCH)
                return self.through(touch.ends, y, end, most)
            if motion.status == "running":
                self.size = motion.h_abs
            self.watch.after_step(motion.t, acting)
        return np.asarray(motion.y)


def _compared(model: OwnModel, best: Integration, other: Integration) -> Certificate:
    """A reference from two computations: how far they are apart is its uncertainty."""
    here = model.corners(best.states)
    apart = distances(here, model.corners(other.states))
    rounding = np.finfo(float).eps * largest(np.abs(here).max(axis=2))
    apart[1:] = np.maximum(apart, rounding)[1:]
    return Certificate(best, other, apart, here, why=best.why or other.why)


def distances(here: Array, there: Array) -> Array:
    """The largest displacement [m] of any corner so far between two motions of corner points [m],
    each of shape (n, corners, 3); infinite from where one is no number."""
    return largest(np.linalg.norm(here - there, axis=2))


def moved(model: OwnModel, before: Array, after: Array) -> float:
    """The largest displacement [m] of any corner between two motions' states, shape (n, k)."""
    return float(distances(model.corners(before), model.corners(after))[-1])


def largest(values: Array) -> Array:
    """The largest of each row so far, infinite from the first row on that is no number; values of
    shape (n, m)."""
    worst = np.where(np.isfinite(values).all(axis=1), values.max(axis=1, initial=0.0), math.inf)
    return np.maximum.accumulate(worst)
