"""Steps of a model from the samples of a recording, and what each leaves of the next sample."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.difference.recording import SINGLE, Recording, resolution_of
from plumbob.engines.own_motion import OwnModel
from plumbob.engines.recorded_step import RecordedSteps, StepInput, StepOutcome
from plumbob.engines.tangent_space import TangentSpace, space_of_layout

# Largest rounding of a step, in its root mean square. Eight nudges give that within a factor of
# 2.5 in all but one of 10,000 numbers, and the rounding is within four times it.
ROUNDING = 10.0
# Residual that a solver may leave, in the largest of those that it leaves with and without a warm
# start
SOLVER = 10.0
# Least allowance of a number, in the largest that the solver leaves of its kind
SOLVER_SPREAD = 0.1
# A step of a recording may differ from a multiple of the model's step by this fraction of it.
STEP_TOLERANCE = 1e-3
QUATERNION = 2.0  # rotation [rad] by a change of 1 of a unit quaternion


def computed_precision(*recordings: Recording) -> type[np.floating[Any]]:
    """Returns the lowest precision in which steps of recordings are taken to be computed."""
    single = any(recording.resolution == SINGLE for recording in recordings)
    return np.float32 if single else np.float64


@dataclass(frozen=True)
class StepLaw:
    """How the steps of a recording are taken: by an integrator, at a step, with the controls of a
    sample before or after."""

    integrator: str
    step: float  # [s]
    # 0: the controls of a sample are held from it on; -1: from the next sample on; 1: before it
    shift: int = 0


@dataclass(frozen=True)
class Allowed:
    """The most that a step may leave of the next sample, in tangent coordinates, shape (m,)."""

    rounding: Array
    solver: Array

    @property
    def whole(self) -> Array:
        """Rounding and solver together."""
        return self.rounding + self.solver


@dataclass(frozen=True)
class SampleSteps:
    """Steps of a model by a law from the samples of a recording."""

    model: OwnModel
    recording: Recording
    law: StepLaw
    space: TangentSpace = field(init=False)
    steps: RecordedSteps = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "space", space_of_layout(self.model.layout))
        steps = self.model.recorded_steps(self.law.integrator, self.law.step)
        object.__setattr__(self, "steps", steps)

    @property
    def precision(self) -> type[np.floating[Any]]:
        """The precision in which the recorded steps are taken to be computed."""
        return computed_precision(self.recording)

    @property
    def intervals(self) -> int:
        """The number of intervals between samples."""
        return len(self.recording.times) - 1

    @cached_property
    def counts(self) -> Array:
        """The number of steps in each interval; 0 if the interval is no multiple of the step."""
        times = self.recording.times
        gaps = np.diff(times) / self.law.step
        counts = np.rint(gaps)
        unit = resolution_of(times[:, None]).unit(np.abs(times).max(initial=0.0))
        tolerance = STEP_TOLERANCE * counts + 2.0 * unit / self.law.step
        return np.where(np.abs(gaps - counts) <= tolerance, counts, 0.0).astype(int)

    @cached_property
    def usual_count(self) -> int:
        """The most frequent number of steps in an interval."""
        values, numbers = np.unique(self.counts, return_counts=True)
        return int(values[np.argmax(numbers)])

    def control(self, interval: int) -> Array:
        """Returns the control that the law holds in an interval."""
        last = len(self.recording.controls) - 1
        row = min(max(interval + self.law.shift, 0), last)
        return np.asarray(self.recording.controls[row])

    def before(
        self, interval: int, warm_start: Array, control: Array | None = None
    ) -> StepInput:
        """Returns the sample before an interval, ready for the steps of that interval under its
        control, or under another `control`."""
        held = self.control(interval) if control is None else control
        count = max(int(self.counts[interval]), 1)
        state = self.recording.states[interval]
        return StepInput(state, np.tile(held, (count, 1)), warm_start)

    def recorded(self, interval: int) -> StepInput:
        """Returns the sample before an interval with its recorded warm start."""
        warm_starts = self.recording.warm_starts
        assert warm_starts is not None
        return self.before(interval, warm_starts[interval])

    def left(self, interval: int, outcome: StepOutcome, ahead: int = 1) -> Array:
        """Returns what an outcome leaves of the sample `ahead` after the one before an interval, in
        tangent coordinates; infinite if the outcome is not finite."""
        row = min(interval + ahead, self.intervals)
        left = self.space.differences(self.recording.states[row], outcome.state)
        return np.where(np.isfinite(left), left, np.inf)

    def unit_after(self, interval: int) -> Array:
        """Returns how finely the sample after an interval is given, in tangent coordinates."""
        return tangent_unit(self.space, self.recording, interval + 1)

    def allowed(self, before: StepInput, interval: int) -> Allowed:
        """Returns what the steps of an interval may leave."""
        outcome, converged = self.steps.after(before), self.steps.converged(before)
        return Allowed(self.rounding(before, interval), self.solver(before, outcome, converged))

    def rounding(self, before: StepInput, interval: int, converged: bool = False) -> Array:
        """Returns what rounding may leave of the steps of an interval, with the model's solver or
        with one that has `converged`: measured by nudges. Engines in single precision factorise in
        other ways than the model, and factorisations mix coordinates: all of a kind may round as
        much as the largest. Up to 0.43 of that is used by four robots in MuJoCo Warp."""
        unit = self.recording.resolution.unit
        nudged = self.steps.nudged(before, self.precision, unit, converged)
        largest = ROUNDING * np.sqrt(np.mean(nudged**2, axis=0))
        if self.precision is np.float32:
            ends = (self.space.velocities, 2 * self.space.velocities)
            for kind in np.split(largest, ends):
                kind[:] = kind.max(initial=0.0)
        return np.asarray(largest + self.unit_after(interval))

    def solver(self, before: StepInput, outcome: StepOutcome, converged: StepOutcome) -> Array:
        """Returns what the solver may leave of the steps from a state: by the difference that its
        iterations make with and without a warm start. `outcome` is that of the steps, `converged`
        that of steps whose solver converges."""
        cold = StepInput(before.state, before.controls, np.zeros_like(before.warm_start))
        differences = [
            np.abs(self.space.differences(iterated.state, converged.state))
            for iterated in (outcome, self.steps.after(cold))
        ]
        solver = np.max(differences, axis=0)
        for part in (slice(0, self.space.velocities), slice(self.space.velocities, None)):
            solver[part] = np.maximum(
                solver[part], SOLVER_SPREAD * solver[part].max(initial=0.0)
            )
        return SOLVER * np.where(np.isfinite(solver), solver, 0.0)

    def acceleration(self, left: Array, interval: int) -> Array:
        """Returns what is left of the velocities as accelerations [m/s^2, rad/s^2]."""
        duration = max(int(self.counts[interval]), 1) * self.law.step
        first = self.space.velocities
        return left[first : 2 * first] / duration


def tangent_unit(space: TangentSpace, recording: Recording, row: int) -> Array:
    """Returns how finely the numbers of a sample are given, in tangent coordinates, shape (m,)."""
    unit = recording.resolution.unit(recording.states[row])
    for first, _ in space.attitudes:
        unit[first : first + 4] = QUATERNION * unit[first : first + 4].max()
    return np.delete(unit, [first for first, _ in space.attitudes])
