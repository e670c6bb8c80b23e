"""The motion of a user's model, computed again in other ways: the bits of each repetition, and if
they differ, the band of rounding and of the solver that its difference is held against."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Literal

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.difference.band import BandMeasurement
from plumbob.engines.difference.difference import MotionDifference, motion_difference
from plumbob.engines.difference.recording import DOUBLE, Recording
from plumbob.engines.difference.sample_steps import SampleSteps, StepLaw
from plumbob.engines.difference.steps_beside import (
    OwnSteps,
    SolverRun,
    StepsBeside,
    compared_steps,
    other_steps,
    solver_run,
)
from plumbob.engines.own_motion import ModelVariation, NotCertifiable, OwnModel, Script
from plumbob.engines.recorded_step import StepInput

THREADS = (1, 2, 4)
COPIES = 10  # runs of the same motion in a batch
OTHERS = 7  # runs of other motions in a batch whose order changes
MOST_REPEATED_STEPS = 20_000  # most steps of a motion that is repeated
BAND_TIME = 0.4  # part of the time in which the band is measured
VARIED_STEPS_TIME = 0.05  # part of the time in which the steps of a variation are checked
RepetitionVerdict = Literal["same bits", "within", "beyond", "open", "not run"]
RepetitionKind = Literal[
    "again", "batch", "jacobian", "converged", "solver", "flag", "sleep", "port"
]


@dataclass(frozen=True)
class Repetition:
    """A motion that is computed again in another way, beside the motion that it should be."""

    name: str
    kind: RepetitionKind
    why: str = ""  # why it has no motion, or an end before the motion's; empty if neither
    diverges: bool = False  # whether it ends before the motion does
    difference: MotionDifference | None = None  # None if it has no motion
    # Single steps from the states of the motion; None if they are the same computation
    steps: StepsBeside | None = None
    solver: SolverRun | None = None  # what the repetition's solver leaves of its run
    own_solver: SolverRun | None = None  # what the solver leaves of the motion that is repeated

    @property
    def verdict(self) -> RepetitionVerdict:
        """The verdict: "beyond" if the motion leaves the band, ends early, or a single step leaves
        more than rounding and the solver allow; "open" if the time ended before all steps were
        checked."""
        if self.diverges or self.factor > 1.0:
            return "beyond"
        if self.difference is None:
            return "not run"
        if self.difference.first is None:
            return "same bits"
        if self.steps is not None and self.steps.why:
            return "open"
        return "within"

    @property
    def factor(self) -> float:
        """The largest ratio of a difference to what rounding and the solver allow, of the motion as
        far as the band reaches, and of single steps."""
        uses = [self.difference.largest_use] if self.difference else []
        return max([*uses, *([self.steps.use] if self.steps else [])], default=math.nan)

    @property
    def begin(self) -> float:
        """The time [s] from which on the motion is beyond; NaN if it is not."""
        times = []
        if self.difference is not None and (self.difference.uses > 1.0).any():
            times.append(float(self.difference.times[np.argmax(self.difference.uses > 1.0)]))
        if self.steps is not None and self.steps.use > 1.0:
            times.append(self.steps.begin)
        return min(times, default=math.nan)

    @property
    def end(self) -> float:
        """The largest difference of any position [m or rad] at the end; NaN without a motion."""
        return float(self.difference.sizes[-1]) if self.difference else math.nan


@dataclass(frozen=True)
class RepeatedMotion:
    """The repetitions of a motion of a model's own steps."""

    model: OwnModel
    script: Script
    control: str  # the source of its controls
    recording: Recording
    repetitions: tuple[Repetition, ...]
    seconds: float  # wall time

    @property
    def name(self) -> str:
        """The name of the model."""
        return self.model.name

    @property
    def beyond(self) -> tuple[Repetition, ...]:
        """The repetitions beyond what rounding and the solver allow. A motion with sleeping bodies
        is not among them: sleep is a change of the model."""
        return tuple(
            row for row in self.repetitions if row.verdict == "beyond" and row.kind != "sleep"
        )

    @property
    def open(self) -> tuple[Repetition, ...]:
        """The repetitions that the time was too short for."""
        return tuple(row for row in self.repetitions if row.verdict == "open")

    def assert_reproducible(self) -> None:
        """Raises AssertionError if a repetition is beyond what rounding and the solver allow."""
        if self.beyond:
            names = ", ".join(row.name for row in self.beyond)
            raise AssertionError(f"{self.name}: beyond rounding and the solver: {names}")


def recorded_run(model: OwnModel, start: StepInput, name: str) -> Recording:
    """Returns the recording of a run of a model's own steps, up to its last finite state."""
    run = model.recorded_steps(model.integrator, model.step).run(start)
    count = len(run.states)
    held = np.vstack([start.controls, start.controls[-1:]])[:count]
    times = np.asarray(model.step * np.arange(count), dtype=float)
    return Recording(name, times, run.states, held, run.warm_starts, DOUBLE)


def start_of(script: Script, model: OwnModel) -> StepInput:
    """Returns the start of a script, with its controls at each step of a model. Raises
    NotCertifiable if there are too many steps."""
    parts = script.parts(model.step)
    count = parts * len(script.controls)
    if count > MOST_REPEATED_STEPS:
        raise NotCertifiable(f"{count} steps; at most {MOST_REPEATED_STEPS} are repeated")
    velocity = model.layout.velocity
    return StepInput(
        state=script.start,
        controls=np.repeat(script.controls, parts, axis=0),
        warm_start=np.zeros(velocity.stop - velocity.start),
    )


@dataclass
class Repeater:
    """The repetitions of one motion, which share the band along it."""

    model: OwnModel
    start: StepInput
    recording: Recording
    allowance: Allowance
    own: OwnSteps = field(init=False)
    band: BandMeasurement = field(init=False)  # along the recording

    def __post_init__(self) -> None:
        samples = samples_of(self.model, self.recording)
        self.own = OwnSteps(samples)
        self.band = self._measurement(samples)

    def repetitions(self) -> Iterator[Repetition]:
        """Yields all repetitions in MuJoCo."""
        self.allowance.progress("the same motion again")
        again = recorded_run(self.model, self.start, "again")
        yield compared_with_band(self.band, "again", "again", again.states)
        for name, run in self._batches():
            self.allowance.progress(name)
            try:
                runs = run()
            except NotCertifiable as why:
                yield Repetition(name, "batch", str(why))
                continue
            states = most_apart(self.recording.states, runs)
            yield compared_with_band(self.band, name, "batch", states)
        for variation in self.model.variations():
            self.allowance.progress(variation.name)
            yield self.varied(variation)

    def _batches(self) -> Iterator[tuple[str, Callable[[], Array]]]:
        """Yields the name of each batch, and a function that returns the states of the runs of this
        motion in it, shape (runs, steps + 1, n)."""
        same = np.tile(self.start.state, (COPIES, 1))
        for threads in THREADS:
            name = f"{COPIES} copies on {threads} thread{'s' if threads > 1 else ''}"
            yield name, partial(self.model.batch, same, self.controls, threads)
        yield f"among {OTHERS} others, in two orders", self._in_both_orders

    @property
    def controls(self) -> Array:
        """The controls of the steps that are finite. MuJoCo ends the process if a batch fails."""
        return self.start.controls[: len(self.recording.states) - 1]

    def _in_both_orders(self) -> Array:
        """Returns the states of this motion among others in a batch, in two orders."""
        rows = np.linspace(0, len(self.recording.states) - 1, OTHERS + 1, dtype=int)
        states = self.recording.states[rows]
        first = self.model.batch(states, self.controls, THREADS[-1])[0]
        last = self.model.batch(states[::-1], self.controls, THREADS[-1])[-1]
        return np.stack([first, last])

    def varied(self, variation: ModelVariation) -> Repetition:
        """Returns the run of a model with a changed setting, compared with the band of the motion
        that it should have, which is the motion without the change. If the bits of the two differ,
        their single steps are compared, too."""
        name, kind = variation.name, variation.kind
        own, band = self.own, self.band
        if kind == "converged":
            recording = recorded_run(variation.unchanged, self.start, "converged")
            own = OwnSteps(samples_of(variation.unchanged, recording))
            band = self._measurement(own.samples)
        try:
            run = recorded_run(variation.model, self.start, name)
        except NotCertifiable as why:
            return Repetition(name, kind, str(why))
        same_bits = np.array_equal(run.states, own.samples.recording.states)
        if same_bits or kind == "sleep":  # the steps of sleeping bodies differ by intent
            return compared_with_band(band, name, kind, run.states)
        changed_step = other_steps(samples_of(variation.model, own.samples.recording))
        steps = compared_steps(own, changed_step, self.allowance.part(VARIED_STEPS_TIME))
        solver = solver_run(samples_of(variation.model, run))
        # The band needs a row for each step of the motion, and the run may end before the motion.
        left = np.zeros((own.samples.intervals, solver.left.shape[1]))
        left[: len(solver.left)] = solver.left
        row = compared_with_band(band, name, kind, run.states, left)
        own_solver = None if kind == "converged" else self.own_solver
        return replace(row, steps=steps, solver=solver, own_solver=own_solver)

    @cached_property
    def own_solver(self) -> SolverRun:
        """The steps of the model's own solver along the motion, and what it leaves of them."""
        return solver_run(self.own.samples)

    def _measurement(self, samples: SampleSteps) -> BandMeasurement:
        """Returns the measurement of a band along the recording of `samples`."""
        allowance = self.allowance.part(BAND_TIME)
        return BandMeasurement(samples, allowance, samples.precision)


def most_apart(states: Array, runs: Array) -> Array:
    """Returns the run, of shape (steps + 1, n), that differs most from `states`, among `runs`."""
    changes = np.abs(runs[:, : len(states)] - states)
    largest = np.nan_to_num(changes, nan=np.inf).max(axis=(1, 2))
    return np.asarray(runs[int(np.argmax(largest))])


def compared_with_band(
    band: BandMeasurement,
    name: str,
    kind: RepetitionKind,
    states: Array,
    left: Array | None = None,
) -> Repetition:
    """Returns a repetition with `states`, whose differences from a recording are compared with the
    band along it. `left` is what the repetition's solver leaves of each step."""
    recording = band.samples.recording
    finite = np.isfinite(states).all(axis=1)
    ended = len(states) if finite.all() else int(np.argmin(finite))
    count = min(ended, len(recording.states))
    diverges = count < len(recording.states)
    why = f"it diverges within {recording.times[count]:g} s" if diverges else ""
    if count < 2:
        return Repetition(name, kind, why, diverges)
    times = recording.times[:count]
    second = replace(recording, name=name, times=times, states=states[:count])
    pairs = np.tile(np.arange(count)[:, None], 2)
    difference = motion_difference(band, second, pairs, left)
    return Repetition(name, kind, why, diverges, difference)


def samples_of(model: OwnModel, recording: Recording) -> SampleSteps:
    """Returns the steps of a model from the samples of a recording of every step."""
    return SampleSteps(model, recording, StepLaw(model.integrator, model.step))
