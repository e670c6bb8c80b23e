"""The steps of a recording that are not the model's: from each sample the model takes one step, and
what it leaves of the next sample is held against what precision and solver allow.

Each step is judged alone, so that a chaotic motion is judged as well as any other. The solver
begins each step where the model's own step before it ended: for a recording of every step from a
reset on, that is its own warm start."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.difference.recording import Recording
from plumbob.engines.difference.sample_steps import (
    STEP_TOLERANCE,
    Allowed,
    SampleSteps,
    StepLaw,
)
from plumbob.engines.difference.step_terms import Cause, cause_of, common_cause, excess_of
from plumbob.engines.own_motion import OwnModel
from plumbob.engines.recorded_step import StepInput, StepOutcome

PROBES = 12  # intervals from which the law of the steps is recognised
LEAST_EXPLAINED = 0.4  # part of the probes that another law must explain
NEARLY_ALL = 0.9  # part of the probes that the model's own law explains if no other is tried
OTHER_COUNTS = (1, 2, 3, 4, 5, 8, 10, 16, 20)  # numbers of steps of another size in an interval
MOST_CAUSES = 8  # findings whose cause is looked for
MOST_STEP_FINDINGS = 100  # findings that are kept; others are counted
# Steps in a row after which the solver of a recording is taken to end as the model's own does: it
# then leaves no more than rounding
ALIKE_STEPS = 8
MOST_PROBES = 48  # steps that leave nothing whose allowance is measured
PART_OF_TIME = 0.2  # part of the allowance in which the law of the steps is recognised


@dataclass(frozen=True)
class StepFinding:
    """A step of a recording that the model does not take."""

    interval: int  # row of the sample before the step
    begin: float  # [s]
    end: float  # [s]
    place: str  # joint or activation with the largest excess
    left: float  # difference of the recorded step from the model's step at `place`
    allowed: float  # largest difference that precision and solver allow at `place`
    unit: str  # unit of `left` and `allowed`
    excess: float  # largest ratio of what is left to what is allowed
    cause: Cause


@dataclass(frozen=True)
class CheckedSteps:
    """The steps of a recording held against those of a model."""

    law: StepLaw
    findings: tuple[StepFinding, ...]
    further: int  # number of further steps that are not the model's
    checked: int  # number of intervals that were checked
    # Largest acceleration that is left and allowed [m/s^2, rad/s^2], and the parts of rounding and
    # solver in the median of what is allowed
    largest_left: float
    largest_allowed: float
    rounding: float
    solver: float
    common: Cause | None = None  # one cause of most findings


def check_steps(model: OwnModel, recording: Recording, allowance: Allowance) -> CheckedSteps:
    """Returns the steps of a recording held against those of a model, within a time."""
    law = recognised_law(model, recording, allowance.part(PART_OF_TIME))
    checker = StepChecker(SampleSteps(model, recording, law), allowance)
    return checker.checked()


def recognised_law(model: OwnModel, recording: Recording, allowance: Allowance) -> StepLaw:
    """Returns the law that explains most of the probed steps of a recording; the model's own if no
    law explains many more, or if the time ends."""
    own = StepLaw(model.integrator, model.step)
    probes = _Probes(SampleSteps(model, recording, own))
    best, most = own, probes.explained(probes.samples)
    if most > NEARLY_ALL:
        return own
    for law in _other_laws(model, recording):
        if allowance.left < 0.0:
            break
        explained = probes.explained(SampleSteps(model, recording, law))
        if explained > max(most, LEAST_EXPLAINED):
            best, most = law, explained
    return best


def _other_laws(model: OwnModel, recording: Recording) -> Iterator[StepLaw]:
    """Yields the laws to try beside the model's own: other controls, integrators and steps."""
    own = StepLaw(model.integrator, model.step)
    shifts = (-1, 1) if recording.controls.any() else ()
    for shift in shifts:
        yield replace(own, shift=shift)
    others = [name for name in model.steppable if name != model.integrator]
    for integrator in others:
        yield replace(own, integrator=integrator)
    gap = float(np.median(np.diff(recording.times)))
    multiple = round(gap / model.step)
    if multiple and abs(gap / model.step - multiple) < STEP_TOLERANCE:
        gap = multiple * model.step  # without the rounding of times
    for count in OTHER_COUNTS:
        if not math.isclose(gap / count, model.step, rel_tol=STEP_TOLERANCE):
            yield replace(own, step=gap / count)
    for integrator in others:
        for shift in shifts:
            yield replace(own, integrator=integrator, shift=shift)
        if not math.isclose(gap, model.step, rel_tol=STEP_TOLERANCE):
            yield replace(own, integrator=integrator, step=gap)


@dataclass(frozen=True)
class _Probes:
    """Intervals of a recording in which laws are tried, and what steps by the first law may leave
    there."""

    samples: SampleSteps  # by the model's own law

    @cached_property
    def intervals(self) -> list[int]:
        """The first intervals, and others that are spread over the recording."""
        last = self.samples.intervals - 1
        spread = np.linspace(0, last, PROBES)
        return [int(k) for k in np.unique([*range(min(PROBES, last + 1)), *spread])]

    @cached_property
    def allowed(self) -> dict[int, Allowed]:
        """The most that steps may leave, by interval."""
        cold = np.zeros(self.samples.space.velocities)
        return {
            interval: self.samples.allowed(self.samples.before(interval, cold), interval)
            for interval in self.intervals
        }

    def explained(self, samples: SampleSteps) -> float:
        """Returns the fraction of the intervals that the steps of a law explain, by rounding alone
        and with the solver: the mean of both."""
        explained = 0
        warm = np.zeros(samples.space.velocities)
        previous = -1
        for interval in self.intervals:
            if not samples.counts[interval]:
                continue
            if samples.recording.warm_starts is not None:
                warm = samples.recording.warm_starts[interval]
            elif interval != previous + 1:
                before = samples.before(interval - 1, np.zeros_like(warm))
                warm = samples.steps.after(before).warm_start
            outcome = samples.steps.after(samples.before(interval, warm))
            warm, previous = outcome.warm_start, interval
            left = np.abs(samples.left(interval, outcome))
            allowed = self.allowed[interval]
            explained += bool((left <= allowed.rounding).all())
            explained += bool((left <= allowed.whole).all())
        return explained / (2 * len(self.intervals))


class StepChecker:
    """Checks the intervals of a recording one after another."""

    def __init__(self, samples: SampleSteps, allowance: Allowance) -> None:
        self.samples, self.allowance = samples, allowance
        self.findings: list[StepFinding] = []
        self.further = 0
        # Steps in a row in which the solver leaves more than rounding and the recording does not
        self.alike = 0
        self.warm_starts: list[Array] = []  # those of the last two intervals
        self.largest_left = self.largest_allowed = 0.0
        self.parts: list[tuple[float, float]] = []

    def checked(self) -> CheckedSteps:
        """Returns the findings in all intervals, or in those that the time allows."""
        samples = self.samples
        warm = np.zeros(samples.space.velocities)
        interval = 0
        while interval < samples.intervals and self.allowance.left > 0.0:
            if samples.recording.warm_starts is not None:
                warm = samples.recording.warm_starts[interval]
            before = samples.before(interval, warm)
            outcome = samples.steps.after(before)
            self.warm_starts = [*self.warm_starts[-1:], warm]
            warm = outcome.warm_start
            interval += self._intervals_explained(interval, before, outcome)
        rounding, solver = np.median(self.parts, axis=0) if self.parts else (0.0, 0.0)
        return CheckedSteps(
            law=samples.law,
            findings=tuple(self.findings),
            further=self.further,
            checked=interval,
            largest_left=self.largest_left,
            largest_allowed=self.largest_allowed,
            rounding=float(rounding),
            solver=float(solver),
            common=common_cause([finding.cause for finding in self.findings]),
        )

    def _intervals_explained(
        self, interval: int, before: StepInput, outcome: StepOutcome
    ) -> int:
        """Adds a finding if the step of an interval is not the model's; returns the number of
        intervals that this explains."""
        samples = self.samples
        left = samples.left(interval, outcome)
        self._note_left(interval, left)
        regular = samples.counts[interval] == samples.usual_count
        fine = bool((np.abs(left) <= samples.unit_after(interval)).all())
        if regular and fine and not self._is_probe(interval, outcome):
            return 1
        allowed = samples.allowed(before, interval)
        self._note_allowed(interval, allowed)
        if regular and excess_of(left, allowed.rounding) <= 1.0:
            self.alike += bool((allowed.solver > allowed.rounding).any())
            return 1
        excess, left = self._least_excess(interval, before, left, allowed)
        if regular and excess <= 1.0 and self.alike < ALIKE_STEPS:
            self.alike = 0
            return 1
        self.alike = 0
        if excess <= 1.0:
            allowed = replace(allowed, solver=np.zeros_like(allowed.solver))
        if len(self.findings) >= MOST_STEP_FINDINGS:
            self.further += 1
            return 1
        cause = Cause("unsearched")
        if len(self.findings) < MOST_CAUSES:
            cause = cause_of(samples, interval, before, outcome, allowed.whole)
        self.findings.append(self._finding(interval, left, allowed, cause))
        return cause.intervals

    def _is_probe(self, interval: int, outcome: StepOutcome) -> bool:
        """Returns whether the allowance of a step is measured even though the step leaves nothing:
        some steps state the threshold, and some show that the solver of the recording ends as the
        model's own does."""
        unsure = self.alike < ALIKE_STEPS and len(self.parts) < MOST_PROBES
        return unsure and (bool(outcome.touching) or interval % PROBES == 0)

    def _note_left(self, interval: int, left: Array) -> None:
        """Keeps the largest acceleration that a step of the model leaves."""
        sizes = np.abs(self.samples.acceleration(left, interval))
        self.largest_left = max(self.largest_left, float(sizes.max(initial=0.0)))

    def _note_allowed(self, interval: int, allowed: Allowed) -> None:
        """Keeps the accelerations that precision and solver allow."""
        rounding, solver = (
            float(self.samples.acceleration(part, interval).max(initial=0.0))
            for part in (allowed.rounding, allowed.solver)
        )
        self.parts.append((rounding, solver))
        self.largest_allowed = max(self.largest_allowed, rounding + solver)

    def _least_excess(
        self, interval: int, before: StepInput, left: Array, allowed: Allowed
    ) -> tuple[float, Array]:
        """Returns the least ratio of what a step leaves to what is allowed, with the solver's warm
        start, without it, and with a solver that converges; and what that step leaves."""
        samples = self.samples
        cold = StepInput(before.state, before.controls, np.zeros_like(before.warm_start))
        rows = [left]
        if (np.abs(left) > allowed.whole).any():
            outcomes = [samples.steps.after(cold), samples.steps.converged(before)]
            earlier = replace(before, warm_start=self.warm_starts[0])
            outcomes.append(samples.steps.after(earlier))
            rows += [samples.left(interval, outcome) for outcome in outcomes]
        excesses = [excess_of(row, allowed.whole) for row in rows]
        best = int(np.argmin(excesses))
        return excesses[best], rows[best]

    def _finding(
        self, interval: int, left: Array, allowed: Allowed, cause: Cause
    ) -> StepFinding:
        """Returns the finding in an interval, at the place with the largest excess."""
        samples = self.samples
        place, size, limit, unit = worst_place(samples, interval, left, allowed.whole)
        times = samples.recording.times
        return StepFinding(
            interval=interval,
            begin=float(times[interval]),
            end=float(times[interval + 1]),
            place=place,
            left=size,
            allowed=limit,
            unit=unit,
            excess=excess_of(left, allowed.whole),
            cause=cause,
        )


def worst_place(
    samples: SampleSteps, interval: int, left: Array, allowed: Array
) -> tuple[str, float, float, str]:
    """Returns the joint or activation with the largest excess, what is left and allowed there, and
    the unit: an acceleration if the velocity is in excess, else a position or an activation."""
    degrees = samples.space.velocities
    ratios = np.abs(left) / np.maximum(allowed, np.finfo(float).tiny)
    rates = slice(degrees, 2 * degrees)
    names, units = samples.steps.place_names, samples.steps.units
    if (ratios[rates] > 1.0).any() or not (ratios > 1.0).any():
        number = int(np.argmax(ratios[rates]))
        size, limit = (samples.acceleration(row, interval)[number] for row in (left, allowed))
        return names[number], abs(float(size)), float(limit), f"{units[number]}/s²"
    number = int(np.argmax(ratios))
    size, limit = abs(float(left[number])), float(allowed[number])
    if number < degrees:
        return names[number], size, limit, units[number]
    return f"activation {number - 2 * degrees}", size, limit, ""
