"""A certified reference of a model's continuous motion, by adaptive integration with two methods.

Smooth motions, with a contact or a limit now and then, are integrated by an explicit pair of order
8, whose step rejection finds each event, and again by a pair of order 5 at another tolerance. If a
contact chatters (a foot slides at its touch threshold), the rates are discontinuous along the
motion and the step of the integration collapses. Contacts then begin over a thin layer, and the
motion is computed for widths that shrink.

The uncertainty is the whole difference of two computations. With layers, it is a bound on the
distance of the motion with the narrowest layer from the limit of vanishing width.
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
    NotControlled,
    OwnModel,
    Script,
)

TIGHT, LOOSE = 1e-10, 1e-8  # relative and absolute tolerances of the two smooth methods
WIDTHS = (1e-5, 1e-6, 3e-7)  # [m] widths of the layers
IN_LAYER, OTHER_IN_LAYER = 1e-7, 1e-6  # tolerances with layers
# Powers of a layer's width to which the distance of the motion from the limit is proportional. The
# duration of a touch at a speed is proportional to the width, the duration of a grazing touch to
# the square root of the width, and the duration of a touch whose acceleration and jerk vanish, too,
# to its fourth root. The smallest power dominates as layers shrink.
POWERS = (0.25, 0.5)
CHATTER, WITHIN = 20, 0.05  # more than CHATTER events within WITHIN seconds are chatter
# Least number of steps into which a touch is divided that a larger step has passed over: some
# stages of these steps lie within the touch.
STEPS_IN_TOUCH = 4.0
FIRST = 0.4  # fraction of the time for the first method
RESOLVED = 5.0  # least multiple of the uncertainty at which an error is quoted
# Difference of two answers of a policy, relative to the largest, that is a jump if the states
# differ by less than SAME_STATE. Together they are a gain of 1000, relative to motion and controls.
ANSWER_JUMP, SAME_STATE = 1e-3, 1e-6
MEASURE = "corner displacement"  # name of the measure of errors in JSON
NOTHING = 1e-9  # [m] displacement that rounding and solver tolerances cause in the steps


@dataclass(frozen=True)
class Certificate:
    """The continuous motion at the ends of the control periods, and its uncertainty."""

    course: Integration
    confirmed_by: Integration
    # [m] largest distance so far of any corner from the confirming motion, shape (n,)
    uncertainty: Array
    corners: Array  # [m] corner points of the bodies, shape (n, corners, 3)
    widths: tuple[float, ...] = ()  # [m] widths of the layers; empty for a smooth motion
    why: str = ""  # why there is no reference, or it ends early
    not_smooth: str = ""  # why layers were needed

    @property
    def known(self) -> int:
        """The index of the last control period at whose end the motion is known."""
        return int(np.flatnonzero(np.isfinite(self.uncertainty))[-1])

    @property
    def states(self) -> Array:
        """The states of the motion up to the last period at which it is known."""
        return self.course.states[: self.known + 1]

    @property
    def until(self) -> float:
        """The time [s] that both computations reach."""
        return min(self.course.until, self.confirmed_by.until)


def certified(model: OwnModel, script: Script, allowance: Allowance) -> Certificate:
    """Returns the reference of `model` under `script`. With an executor, the confirming computation
    runs in parallel, with bitwise the same result. If nothing can be certified, the uncertainty is
    infinite after the start and `why` gives the reason."""
    return known_part(_whole_reference(model, script, allowance))


def known_part(reference: Certificate) -> Certificate:
    """Returns the reference up to the last time at which it says something about the motion: its
    uncertainty there is less than the largest displacement so far, or no more than rounding
    causes."""
    moved_by = largest_distances(reference.corners[:1], reference.corners)
    uncertainty = reference.uncertainty
    last_telling = int(np.flatnonzero((uncertainty < moved_by) | (uncertainty <= NOTHING))[-1])
    end = reference.known
    if last_telling >= end:
        return reference
    why = f"known to ±{uncertainty[end]:.1e} m only, the motion is {moved_by[end]:.2g} m"
    return replace(
        reference,
        uncertainty=np.where(np.arange(len(uncertainty)) > last_telling, math.inf, uncertainty),
        why="; ".join(filter(None, (why, reference.why))),
    )


def _whole_reference(model: OwnModel, script: Script, allowance: Allowance) -> Certificate:
    """Returns the reference, smooth if possible and else with layers, before `known_part` removes
    late parts that say nothing."""
    seconds = allowance.seconds
    second = allowance.start(integration, model, script, "RK45", LOOSE, (1.0 - FIRST) * seconds)
    first = integration(model, script, "DOP853", TIGHT, FIRST * seconds)
    smooth = _certificate_of_two(model, first, second())
    if not first.why:
        return smooth
    layered, ended = _layered_reference(model, script, allowance)
    if layered is not None and layered.until > smooth.until:
        why = "" if layered.until >= script.duration * (1 - 1e-9) else layered.why or ended
        return replace(layered, why=why, not_smooth=first.why)
    after = f"; with contacts over a layer, {ended}" if ended else ""
    return replace(smooth, why=first.why + after)


def start_certificate(model: OwnModel, script: Script) -> Certificate:
    """Returns a certificate of the start alone."""
    start = Integration(script.start[None], 0.0)
    return _certificate_of_two(model, start, start)


def _layered_reference(
    model: OwnModel, script: Script, allowance: Allowance
) -> tuple[Certificate | None, str]:
    """Returns the motion with contacts that begin over layers, which shrink, and the reason why one
    of the computations ended; None if one of them has no duration."""
    computations = [*((width, IN_LAYER) for width in WIDTHS), (WIDTHS[-1], OTHER_IN_LAYER)]
    parallel = 1 if allowance.executor is None else 2
    courses = list[Integration]()
    while len(courses) < len(computations):
        seconds = allowance.left * parallel / (len(computations) - len(courses))
        runs = [
            allowance.start(integration, model, script, "RK45", tolerance, seconds, width)
            for width, tolerance in computations[len(courses) :][:parallel]
        ]
        courses += [run() for run in runs]
        if not all(course.until > 0.0 for course in courses):
            return None, next(course.why for course in courses if course.why)
    ended = next((course.why for course in courses if course.why), "")
    return _certificate_of_layers(model, courses[:-1], courses[-1]), ended


def _certificate_of_layers(
    model: OwnModel, layers: Sequence[Integration], again: Integration
) -> Certificate:
    """Returns the motion with the last, narrowest, of `layers`. Its uncertainty is the sum of its
    distance from the limit and its difference from `again`, computed at another tolerance."""
    comparisons = [
        _certificate_of_two(model, narrow, wide) for wide, narrow in pairwise(layers)
    ]
    narrowest = comparisons[-1]
    at_other_tolerance = _certificate_of_two(model, layers[-1], again)
    return replace(
        narrowest,
        uncertainty=distance_to_limit(WIDTHS, [r.uncertainty for r in comparisons])
        + at_other_tolerance.uncertainty,
        widths=WIDTHS,
        why=narrowest.why or at_other_tolerance.why,
    )


def distance_to_limit(widths: Sequence[float], distances: Sequence[Array]) -> Array:
    """Returns a bound on the distance of the motion with the last, narrowest, of `widths` from the
    limit, shape (n,). `distances` has the distances between the motions with successive widths.

    The power of the width comes from the ratio of two of these distances, within `POWERS`. If only
    two widths are known, or the distances do not fall as any power, the smallest power is used. The
    largest bound counts, since one distance may be small by chance.
    """
    powers = np.linspace(*POWERS, 101)
    steps = np.array([wide**powers - narrow**powers for wide, narrow in pairwise(widths)])
    power = np.full(distances[-1].shape, POWERS[0])
    if len(distances) > 1:
        with np.errstate(divide="ignore", invalid="ignore"):
            power = np.interp(
                np.nan_to_num(distances[-2] / distances[-1]), steps[-2] / steps[-1], powers
            )
    bounds = [
        difference * widths[-1] ** power / (wide**power - narrow**power)
        for difference, (wide, narrow) in zip(distances, pairwise(widths), strict=True)
    ]
    return np.asarray(np.max(bounds, axis=0))


class _TimeAndChatterWatch:
    """Ends an integration when its time is spent and, unless `many` events are allowed, when
    contacts chatter. `events` has the times [s] at which the set of acting contacts changed."""

    def __init__(self, field: Any, many: bool, seconds: float) -> None:
        self.field, self.many, self.ends = field, many, time.process_time() + seconds
        self.events: list[float] = []
        self.before: bytes | None = None

    def __call__(self, at: float, state: Array) -> Array:
        """Returns the rates of a state `at` a time [s]. Raises NotCertifiable if the time is
        spent."""
        if time.process_time() > self.ends:
            raise NotCertifiable(f"{OUT_OF_TIME} at {at:.4g} s")
        return np.asarray(self.field(at, state))

    def after_step(self, at: float, acting: bytes) -> None:
        """Compares the contacts that act `at` a time [s] with those before. Raises NotCertifiable
        if they chatter."""
        if acting != self.before:
            if self.before is not None:
                self.events.append(at)
            self.before = acting
        recent = self.events[-CHATTER - 1 :]
        if not self.many and len(recent) > CHATTER and recent[-1] - recent[0] < WITHIN:
            raise NotCertifiable(f"contacts chatter from {recent[0]:.4g} s on")


@np.errstate(all="ignore")  # a motion without bounds is refused below
def integration(
    model: OwnModel,
    script: Script,
    method: str,
    tolerance: float,
    seconds: float,
    width: float = 0.0,
) -> Integration:
    """Returns the motion of `model` under `script` by an adaptive method of scipy's, restarted with
    each control period. Contacts begin over a layer of this `width` [m], or at once for 0. The
    motion ends early if its time is spent, the step collapses, or, without a layer, events come too
    often."""
    field = model.field(width)
    watch = _TimeAndChatterWatch(field, width > 0.0, seconds)
    touches = model.hidden_touches(field, script.start)
    integrator = _Integrator(method, watch, tolerance, touches)
    states = np.full((len(script.controls) + 1, script.start.size), np.nan)
    states[0] = y = field.normalised(script.start)
    controls = np.full_like(script.controls, np.nan, dtype=float)
    done, why = 0, ""
    ask = script.new_run()
    try:
        for k in range(len(controls)):
            start = k * script.period
            end = (k + 1) * script.period
            controls[k] = ask(k, y)
            field.hold(controls[k], start, y)
            y = field.normalised(integrator.through(start, y, end, script.period))
            if not np.isfinite(y).all():
                raise NotCertifiable(f"the motion has no bounds from {end:.4g} s on")
            states[k + 1] = y
            done = k + 1
    except (NotCertifiable, NotControlled) as reason:
        why = str(reason)
    return Integration(states, done * script.period, tuple(watch.events), why, controls)


class _Integrator:
    """One of scipy's adaptive methods along a field. Each step is searched for hidden touches."""

    def __init__(
        self, method: str, watch: _TimeAndChatterWatch, tolerance: float, touches: Any
    ) -> None:
        from scipy import integrate

        self.start_run = partial(
            getattr(integrate, method), watch, rtol=tolerance, atol=tolerance
        )
        self.watch, self.touches = watch, touches
        # [s] first step of the next run: the last step that the end of its run did not shorten
        self.size: float | None = None

    def through(self, start: float, y: Array, end: float, most: float) -> Array:
        """Returns the state at `end` [s] of the motion from the state `y` at `start` [s], by steps
        of `most` [s] at most. A touch is a short contact of two geoms. If a step passes over a
        touch, three runs replace it: up to the touch, through the touch by a few steps, and on to
        the `end`."""
        size = min(self.size, 0.999 * (end - start)) if self.size else None
        motion = self.start_run(start, y, end, first_step=size, max_step=most)
        while motion.status == "running":
            before, y = motion.t, motion.y
            motion.step()
            if motion.status == "failed":
                raise NotCertifiable(f"the step collapses at {motion.t:.6g} s")
            acting = self.watch.field.active()
            touch = self.touches.within(motion.t, motion.dense_output)
            if touch is not None:
                y = self.through(before, y, touch.begins, most)
                lasting = touch.ends - touch.begins
                if lasting > 0.0:
                    y = self.through(touch.begins, y, touch.ends, lasting / STEPS_IN_TOUCH)
                return self.through(touch.ends, y, end, most)
            if motion.status == "running":
                self.size = motion.h_abs
            self.watch.after_step(motion.t, acting)
        return np.asarray(motion.y)


def _certificate_of_two(model: OwnModel, best: Integration, other: Integration) -> Certificate:
    """Returns a reference from two computations, whose distance is its uncertainty."""
    corners = model.corners(best.states)
    uncertainty = largest_distances(corners, model.corners(other.states))
    rounding = np.finfo(float).eps * running_maximum(np.abs(corners).max(axis=2))
    uncertainty[1:] = np.maximum(uncertainty, rounding)[1:]
    why = best.why or other.why
    jump = first_jump(best, other)
    if jump is not None:
        uncertainty[jump + 1 :] = math.inf
        apart = float(np.abs(best.states[jump] - other.states[jump]).max())
        answers = float(np.abs(best.controls[jump] - other.controls[jump]).max())
        why = (
            f"the policy is discontinuous: in control period {jump + 1} its answers to two states "
            f"{apart:.1g} apart differ by {answers:.2g}"
        )
    return Certificate(best, other, uncertainty, corners, why=why)


def first_jump(best: Integration, other: Integration) -> int | None:
    """Returns the first period in which two computations of a motion have controls that differ by
    more than ANSWER_JUMP of the largest control, although their states differ by less than
    SAME_STATE of the largest number of a state; None if there is none. Only a policy that is
    discontinuous there, or has a gain of thousands, answers so."""
    count = min(len(best.controls), len(other.controls))
    if not count or not best.controls.shape[1]:
        return None
    with np.errstate(invalid="ignore"):
        answers = np.abs(best.controls[:count] - other.controls[:count]).max(axis=1)
        states = np.abs(best.states[:count] - other.states[:count]).max(axis=1)
        largest = [np.nanmax(np.abs(x), initial=0.0) for x in (best.controls, best.states)]
        jumps = (answers > ANSWER_JUMP * largest[0]) & (states < SAME_STATE * largest[1])
    return int(np.argmax(jumps)) if jumps.any() else None


def largest_distances(here: Array, there: Array) -> Array:
    """Returns the largest displacement [m] of any corner so far between two motions of corner
    points [m], each of shape (n, corners, 3); infinite from the first NaN on."""
    return running_maximum(np.linalg.norm(here - there, axis=2))


def largest_displacement(model: OwnModel, before: Array, after: Array) -> float:
    """Returns the largest displacement [m] of any corner between two motions' states, shape (n,
    k)."""
    return float(largest_distances(model.corners(before), model.corners(after))[-1])


def running_maximum(values: Array) -> Array:
    """Returns the largest of `values`, shape (n, m), in each row and the rows before it; infinite
    from the first NaN on."""
    worst = np.where(np.isfinite(values).all(axis=1), values.max(axis=1, initial=0.0), math.inf)
    return np.maximum.accumulate(worst)
