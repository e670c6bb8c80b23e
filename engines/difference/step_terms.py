"""The cause of a recorded step that is not the model's: the first change of the model, of its
controls or of the samples that explains it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.difference.sample_steps import SampleSteps
from plumbob.engines.recorded_step import StepInput, StepOutcome, Suspect

FACTOR_STEP = 1e-6  # difference of the factor of a suspect for its derivative
CONTROL_STEP = 1e-6  # difference of a control for the derivative of a step
LARGEST_FACTOR = 10.0  # largest factor on a part of the model that is tried
LIKELY = 0.5  # part of what is left that the derivative by a factor may leave at first
FACTOR_ITERATIONS = 3  # steps of Newton's method to the factor of a suspect
# Part of what is left that a cause may leave: rounding of the derivative, and of the second order
REST = 1e-3
SAME_FACTOR = 0.02  # relative spread of the factors of one cause of several steps
# Steps by a model that is nudged by what a step allows: two in a row magnify it by this at most
TWO_STEPS = 4.0


@dataclass(frozen=True)
class Cause:
    """A cause of a step that is not the model's.

    The kinds are: "repeated", "dropped", "swapped", "sample" (one sample alone), "late" and "early"
    (the control of the sample before or after), "unactuated", "contact", "integrator", "factor" (a
    part of the model times a factor), "joint" (no single cause), and "unsearched"."""

    kind: str
    part: str = ""  # contact, integrator or part of the model
    factor: float | None = None  # factor on the numbers of the part of the model
    intervals: int = 1  # number of intervals that the cause explains
    # All parts of the model, each with a factor, of which any one explains the step
    factors: tuple[tuple[str, float], ...] = ()


def cause_of(
    samples: SampleSteps,
    interval: int,
    before: StepInput,
    outcome: StepOutcome,
    allowed: Array,
) -> Cause:
    """Returns the cause of a step that is not the model's. `outcome` is the model's step from the
    sample `before`, and `allowed` what it may leave."""
    for cause in _of_samples(samples, interval, before, outcome, allowed):
        return cause
    for cause, changed in _of_inputs(samples, interval, before, outcome):
        if is_within(samples.left(interval, changed), allowed):
            return cause
    left = samples.left(interval, outcome)
    factors = []
    for suspect in samples.steps.suspects():
        factor = _factor(suspect, samples, interval, before, allowed)
        if factor is None:
            continue
        rest = samples.left(interval, suspect.after(before, factor))
        if is_within(rest, np.maximum(allowed, REST * excess_of(left, allowed) * allowed)):
            factors.append((suspect.name, factor))
    if len(factors) == 1:
        return Cause("factor", *factors[0], factors=tuple(factors))
    return Cause("joint", factors=tuple(factors))


def is_within(left: Array, allowed: Array) -> bool:
    """Returns whether what is left is nowhere more than is allowed."""
    return bool((np.abs(left) <= allowed).all())


def excess_of(left: Array, allowed: Array) -> float:
    """Returns the largest ratio of what a step leaves to what is allowed."""
    ratios = np.abs(left) / np.maximum(allowed, np.finfo(float).tiny)
    return float(np.where(left == 0.0, 0.0, ratios).max(initial=0.0))


def _of_samples(
    samples: SampleSteps,
    interval: int,
    before: StepInput,
    outcome: StepOutcome,
    allowed: Array,
) -> Iterator[Cause]:
    """Yields a cause in the order of the samples: one that is repeated, dropped, swapped or alone
    in being wrong."""
    states = samples.recording.states
    counts = samples.counts
    if np.array_equal(states[interval], states[interval + 1]):
        yield Cause("repeated")
    if counts[interval] != samples.usual_count:
        yield Cause("dropped")
    if interval + 2 > samples.intervals:
        return
    if is_within(samples.left(interval, outcome, 2), allowed):
        last = min(3, samples.intervals - interval)
        yield Cause("swapped", intervals=last)
    controls = [samples.control(interval + 1), samples.control(interval)]
    controls.append((controls[0] + controls[1]) / 2.0)
    for number, control in enumerate(controls):
        held = np.tile(control, (len(before.controls), 1))
        second = samples.steps.after(StepInput(outcome.state, held, outcome.warm_start))
        if number == 0 and is_within(samples.left(interval, second, 2), TWO_STEPS * allowed):
            yield Cause("sample", intervals=2)
        if is_within(samples.left(interval, second), TWO_STEPS * allowed):
            yield Cause("dropped")
    if _fits_a_control(samples, interval, outcome, TWO_STEPS * allowed):
        yield Cause("dropped")


def _fits_a_control(
    samples: SampleSteps, interval: int, outcome: StepOutcome, allowed: Array
) -> bool:
    """Returns whether a second step, from an outcome on and under some control, ends at the sample
    after an interval: the control of a dropped sample is not known."""
    control = samples.control(interval).copy()
    scale = np.maximum(allowed, np.finfo(float).tiny)
    count = max(int(samples.counts[interval]), 1)

    def left(held: Array) -> Array:
        """Returns what the second step under a control leaves, in what is allowed."""
        before = StepInput(outcome.state, np.tile(held, (count, 1)), outcome.warm_start)
        return np.asarray(samples.left(interval, samples.steps.after(before)) / scale)

    for _ in range(FACTOR_ITERATIONS):
        here = left(control)
        if not control.size or not np.isfinite(here).all():
            break
        moved = control + CONTROL_STEP * np.eye(control.size)
        slopes = np.array([(left(row) - here) / CONTROL_STEP for row in moved]).T
        largest = np.abs(slopes).max(initial=0.0)
        if not 0.0 < largest < np.inf:
            break
        change = np.linalg.lstsq(slopes / largest, here / largest, rcond=None)[0]
        control = control - np.asarray(change)
    return bool((np.abs(left(control)) <= 1.0).all())


def _of_inputs(
    samples: SampleSteps, interval: int, before: StepInput, outcome: StepOutcome
) -> Iterator[tuple[Cause, StepOutcome]]:
    """Yields causes with the steps that they would make: other controls, a contact that is missing,
    another integrator."""
    after = samples.steps.after
    for kind, other in (("late", interval - 1), ("early", interval + 1)):
        if 0 <= other < len(samples.recording.controls):
            control = samples.control(other)
            yield Cause(kind), after(samples.before(interval, before.warm_start, control))
    if before.controls.any():
        none = replace(before, controls=np.zeros_like(before.controls))
        yield Cause("unactuated"), after(none)
    for entry in outcome.touching:
        (name,) = samples.steps.names_of((entry,))
        if entry[2]:
            missing = samples.steps.without_contact(before, entry[2])
            yield Cause("contact", name.removeprefix("contact ")), missing
    for integrator in samples.model.steppable:
        if integrator != samples.law.integrator:
            others = samples.model.recorded_steps(integrator, samples.law.step)
            yield Cause("integrator", integrator), others.after(before)


def _factor(
    suspect: Suspect,
    samples: SampleSteps,
    interval: int,
    before: StepInput,
    allowed: Array,
) -> float | None:
    """Returns the factor on a part of the model that leaves least, in what is allowed; None if the
    part has no effect."""
    scale = np.maximum(allowed, np.finfo(float).tiny)

    def left(factor: float) -> Array:
        """Returns what the steps with a factor leave, in what is allowed."""
        return np.asarray(samples.left(interval, suspect.after(before, factor)) / scale)

    factor = 1.0
    for _ in range(FACTOR_ITERATIONS):
        here = left(factor)
        with np.errstate(invalid="ignore"):  # infinite where the step is not finite
            slope = (left(factor + FACTOR_STEP) - here) / FACTOR_STEP
        largest = float(np.abs(slope).max(initial=0.0))
        if not 0.0 < largest < np.inf or not np.isfinite(here).all():
            return None
        along = slope / largest
        change = float(along @ here) / float(along @ along)
        rest = float(np.linalg.norm(here - change * along))
        if factor == 1.0 and rest > LIKELY * float(np.linalg.norm(here)):
            return None
        factor -= change / largest
        if not 0.0 <= factor <= LARGEST_FACTOR:
            return None
    return factor


def common_cause(causes: Sequence[Cause]) -> Cause | None:
    """Returns the one cause of several steps: one kind of all of them, or one part of the model
    whose factor is the same in all; None if there is none."""
    causes = [cause for cause in causes if cause.kind != "unsearched"]
    if len(causes) < 3:
        return None
    shared = set.intersection(*({name for name, _ in cause.factors} for cause in causes))
    spreads = {name: _spread(causes, name) for name in sorted(shared)}
    steadiest = min(spreads, key=lambda name: spreads[name], default="")
    if steadiest and spreads[steadiest] <= SAME_FACTOR:
        factors = [dict(cause.factors)[steadiest] for cause in causes]
        return Cause("factor", steadiest, float(np.median(factors)))
    kinds = {
        (cause.kind, cause.part) for cause in causes if cause.kind not in ("joint", "factor")
    }
    if len(kinds) == 1 and len({cause.kind for cause in causes}) == 1:
        return causes[0]
    return None


def _spread(causes: Sequence[Cause], name: str) -> float:
    """Returns the spread of the factors of a part in several causes, relative to their excess over
    1."""
    excesses = np.array([dict(cause.factors)[name] - 1.0 for cause in causes])
    middle = abs(float(np.median(excesses)))
    return float(np.ptp(excesses)) / middle if middle else np.inf
