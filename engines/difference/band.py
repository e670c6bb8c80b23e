"""The band of a recorded motion: how far apart rounding and the solver's tolerance let two runs
come. It is measured step by step along one recording and carried by step Jacobians."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from plumbob.analytic.errors.rounding_band import (
    LARGEST,
    BandSample,
    StepRounding,
    carried_band,
)
from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.difference.sample_steps import ROUNDING, SampleSteps
from plumbob.engines.recorded_step import StepInput

# Sizes of the differences [m, rad, ...] of a step Jacobian, tried in this order until no contact
# begins or ends within a difference. The smallest leaves 1e-4 of rounding.
DIFFERENCES = (1e-7, 1e-9, 1e-11)
LINEAR = 1e-2  # [m, rad, m/s, ...] bound up to which a difference is taken to grow linearly
# Random directions, to the edge of the band, in which contacts are looked for
BAND_DIRECTIONS = 3


@dataclass(frozen=True)
class Band:
    """The band after each interval from `first` on, until it ends."""

    first: int  # first interval that the band covers
    samples: tuple[BandSample, ...]
    why: str = ""  # why it ends before the recording does; empty if it does not
    opened: str = ""  # the contact that begins or ends within the band; empty if none does

    @property
    def end(self) -> int:
        """The row of the last sample that the band covers."""
        return self.first + len(self.samples)


@dataclass
class BandMeasurement:
    """The measurement of bands along a recording. What a step contributes is measured once."""

    samples: SampleSteps
    allowance: Allowance
    precision: type[np.floating[Any]]  # in which the motions are computed
    why: str = field(default="", init=False)
    opened: str = field(default="", init=False)
    steps: dict[int, StepRounding] = field(default_factory=dict, init=False)

    def band(self, first: int, start: Array, left: Array | None = None) -> Band:
        """Returns the band from an interval on, with a difference `start` of the states there, in
        tangent coordinates. If the other run has another solver, `left` is the error that this
        solver leaves in each step, shape (intervals, m)."""
        self.why = self.opened = ""
        rows = list[BandSample]()
        # Engines in single precision have an arithmetic of their own: a step of theirs may round as
        # much as `SampleSteps.rounding` allows.
        largest = ROUNDING if self.precision is np.float32 else LARGEST
        for row in carried_band(self._contributions(first, rows, left), start, largest):
            rows.append(row)
        return Band(first, tuple(rows), self.why, self.opened)

    def _contributions(
        self, first: int, rows: list[BandSample], left: Array | None
    ) -> Iterator[StepRounding]:
        """Yields what each step contributes to the band whose `rows` are known so far, until the
        band opens or the time ends."""
        samples = self.samples
        warm = np.zeros(samples.space.velocities)
        for interval in range(first, samples.intervals):
            if samples.recording.warm_starts is not None:
                warm = samples.recording.warm_starts[interval]
            state = samples.recording.states[interval]
            if rows and self._ends(state, rows[-1], interval):
                return
            before = samples.before(interval, warm)
            if samples.recording.warm_starts is None:
                warm = samples.steps.after(before).warm_start
            if interval not in self.steps:
                self.steps[interval] = self._measured(before)
            step = self.steps[interval]
            if not (np.isfinite(step.jacobian).all() and np.isfinite(step.nudged).all()):
                self.why = "the model's step is not finite"
                return
            if left is not None:
                step = replace(step, left=np.stack([step.left, left[interval]]))
            yield step

    def _measured(self, before: StepInput) -> StepRounding:
        """Returns what the steps from a state contribute to a band."""
        samples = self.samples
        outcome, converged = samples.steps.after(before), samples.steps.converged(before)
        return StepRounding(
            jacobian=self._jacobian(before),
            nudged=samples.steps.nudged(before, self.precision, np.zeros_like),
            left=samples.space.differences(converged.state, outcome.state),
        )

    def _ends(self, state: Array, row: BandSample, interval: int) -> bool:
        """Returns whether the band ends at a state, and keeps the reason."""
        known = interval in self.steps
        if self.allowance.left < 0.0 and not known:
            self.why = "the time given for it ended"
        elif not row.bound.max(initial=0.0) < LINEAR:
            self.why = f"the band has grown to {LINEAR:g}"
        else:
            self.opened = self._opening(state, row, interval)
            self.why = f"{self.opened} begins or ends within it" if self.opened else ""
        return bool(self.why)

    def _opening(self, state: Array, row: BandSample, interval: int) -> str:
        """Returns the name of a contact or limit that is active in one part of the band around a
        state only; empty if there is none."""
        samples = self.samples
        values, vectors = np.linalg.eigh(row.covariance)
        roots = vectors * np.sqrt(np.maximum(values, 0.0))
        drawn = np.random.default_rng(interval).standard_normal((BAND_DIRECTIONS, len(values)))
        shifts = np.vstack([roots[:, -1], drawn @ roots.T])
        degrees = samples.space.velocities
        widths = np.abs(shifts[:, :degrees]).max(axis=1, keepdims=True)
        bound = row.bound[:degrees].max()
        shifts = np.where(
            widths > 0.0, bound * shifts / np.where(widths > 0.0, widths, 1.0), 0.0
        )
        here = set(samples.steps.touching(state))
        for shift in (*shifts, *-shifts):
            there = set(samples.steps.touching(samples.space.shifted(state, shift)))
            if there != here:
                return samples.steps.names_of(tuple(sorted(there ^ here)))[0]
        return ""

    def _jacobian(self, before: StepInput) -> Array:
        """Returns the derivative of the state after steps by the state before, shape (m, m), with a
        solver that converges."""
        samples = self.samples
        size = samples.space.size(before.state)
        for difference in DIFFERENCES:
            shifts = difference * np.eye(size)
            sides = (
                samples.space.shifted(before.state, shifts),
                samples.space.shifted(before.state, -shifts),
            )
            if difference == DIFFERENCES[-1] or self._alike(before, sides):
                break
        ahead, behind = (np.array([self._end(before, row) for row in rows]) for rows in sides)
        return samples.space.differences(ahead, behind).T / (2.0 * difference)

    def _end(self, before: StepInput, state: Array) -> Array:
        """Returns the state after the steps of `before` from another state."""
        start = StepInput(state, before.controls, before.warm_start)
        return self.samples.steps.converged(start).state

    def _alike(self, before: StepInput, sides: tuple[Array, Array]) -> bool:
        """Returns whether the same contacts and limits are active in a state and in states on both
        sides of it whose positions differ."""
        steps = self.samples.steps
        here = steps.touching(before.state)
        positions = self.samples.space.velocities
        return all(steps.touching(row) == here for rows in sides for row in rows[:positions])
