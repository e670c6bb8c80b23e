"""Two recorded motions of a model: where they first differ, how the difference grows beside the
band that rounding makes, and the steps of each that are not the model's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.difference.band import Band, BandMeasurement
from plumbob.engines.difference.recording import Recording
from plumbob.engines.difference.sample_steps import (
    STEP_TOLERANCE,
    SampleSteps,
    computed_precision,
    tangent_unit,
)
from plumbob.engines.difference.step_check import CheckedSteps, check_steps
from plumbob.engines.own_motion import OwnModel

Places = NDArray[np.int_]  # indices of samples
STEPS_TIME = 0.3  # part of the time in which the steps of each recording are checked


@dataclass(frozen=True)
class SampleDifference:
    """A difference of two recordings at one sample."""

    time: float  # [s]
    place: str  # joint or activation with the largest difference
    what: str  # "position", "velocity" or "activation"
    size: float  # [m, rad, m/s, ...]


@dataclass(frozen=True)
class MotionDifference:
    """The difference of two recordings at their common samples, beside the band. Sizes are the
    largest of any position [m or rad]; NaN where the band does not reach."""

    times: Array  # [s], shape (n,)
    sizes: Array
    estimates: Array  # root mean square of what rounding makes
    bounds: Array  # most that rounding, solver and the difference at the start make
    solver: Array  # part of the solver in the bounds
    # Largest ratio of the difference to the bound, of positions, velocities and activations
    uses: Array
    first: SampleDifference | None  # None if all samples have the same bits
    at_start: bool  # whether the first common samples differ by more than their rounding
    # Sample with the largest use of the band, as far as the band reaches
    largest: SampleDifference | None
    until: float  # [s] time up to which the band reaches
    why: str  # why the band ends there; empty if it reaches the end
    opened: str  # contact or limit that begins or ends within the band; empty if none does

    @property
    def largest_use(self) -> float:
        """The largest ratio of the difference to the bound, as far as the band reaches."""
        known = self.uses[np.isfinite(self.uses)]
        return float(known.max(initial=0.0))

    @property
    def reached(self) -> int:
        """The index of the last sample that the band reaches."""
        return int(np.flatnonzero(np.isfinite(self.uses))[-1])


@dataclass(frozen=True)
class ComparedMotions:
    """One or two recordings of a model, their steps held against the model's, and their
    difference."""

    model: OwnModel
    recordings: tuple[Recording, ...]
    steps: tuple[CheckedSteps, ...]
    difference: MotionDifference | None


def compared_motions(
    model: OwnModel, recordings: tuple[Recording, ...], allowance: Allowance
) -> ComparedMotions:
    """Returns the steps of one or two recordings held against those of a model, and the difference
    of two recordings. Raises ParameterError if two recordings have no times in common."""
    pairs = common_rows(*recordings, model.step) if len(recordings) == 2 else None
    steps = []
    for recording in recordings:
        allowance.progress(f"the steps of {recording.name}")
        steps.append(check_steps(model, recording, allowance.part(STEPS_TIME)))
    difference = None
    if pairs is not None:
        allowance.progress("the band of rounding")
        samples = SampleSteps(model, recordings[0], steps[0].law)
        measurement = BandMeasurement(samples, allowance, computed_precision(*recordings))
        difference = motion_difference(measurement, recordings[1], pairs)
    return ComparedMotions(model, recordings, tuple(steps), difference)


def common_rows(first: Recording, second: Recording, step: float) -> Places:
    """Returns the rows of two recordings at common times, shape (n, 2). Raises ParameterError if
    there are fewer than two."""
    nearest = np.clip(np.searchsorted(second.times, first.times), 1, len(second.times) - 1)
    before = first.times - second.times[nearest - 1] < second.times[nearest] - first.times
    rows = np.where(before, nearest - 1, nearest)
    alike = np.abs(second.times[rows] - first.times) <= STEP_TOLERANCE * step
    pairs = np.stack([np.flatnonzero(alike), rows[alike]], axis=1)
    if len(pairs) < 2:
        shown = f"times {second.times[0]:g} s to {second.times[-1]:g} s"
        wanted = f"a recording with times in common with {first.name}"
        raise ParameterError(second.name, shown, wanted)
    return pairs


def motion_difference(
    measurement: BandMeasurement,
    second: Recording,
    pairs: Places,
    left: Array | None = None,
) -> MotionDifference:
    """Returns the difference of two recordings at the rows of `pairs`, and the band along the
    first, measured by `measurement`, from the last common sample on at which they have the same
    bits. If the second has another solver, `left` is what that solver leaves of each step, shape
    (intervals, m)."""
    samples = measurement.samples
    first = samples.recording
    states, others = first.states[pairs[:, 0]], second.states[pairs[:, 1]]
    changes = samples.space.differences(others, states)
    units = np.array(
        [
            tangent_unit(samples.space, first, row) + tangent_unit(samples.space, second, other)
            for row, other in pairs.tolist()
        ]
    )
    at_start = bool((np.abs(changes[0]) > units[0]).any())
    differing = np.flatnonzero((states != others).any(axis=1))
    if not differing.size:
        return _record(samples, pairs, changes, np.zeros((4, len(pairs))), at_start, None)
    begin = max(int(differing[0]) - 1, 0)
    band = measurement.band(int(pairs[begin, 0]), changes[begin], left)
    degrees = samples.space.velocities
    rows = _band_rows(band, pairs[:, 0] - band.first, changes, units, degrees)
    return _record(samples, pairs, changes, rows, at_start, band)


def _band_rows(band: Band, places: Places, changes: Array, units: Array, degrees: int) -> Array:
    """Returns the largest estimate, bound and part of the solver of any position, and the use of
    the band by the `changes`, at samples that come `places` samples after the first of the band,
    shape (4, n): before the band 0, after it NaN. The first `degrees` numbers are positions. The
    recordings are given in `units`."""
    rows = np.zeros((4, len(places)))
    for number, place in enumerate(places.tolist()):
        if place > len(band.samples):
            rows[:, number] = np.nan
        elif place > 0:
            sample = band.samples[place - 1]
            parts = (sample.estimate, sample.bound, sample.solver)
            rows[:3, number] = [part[:degrees].max() for part in parts]
            rows[3, number] = use_by_kind(
                changes[number], sample.bound + units[number], degrees
            )
    return rows


def use_by_kind(change: Array, bound: Array, degrees: int) -> float:
    """Returns the largest ratio of a difference to the bound of its kind: positions, velocities and
    activations, each with the largest bound of its kind. Factorisations mix coordinates, so that
    their rounding is bounded by the largest coordinate and not by each."""
    ends = (degrees, 2 * degrees)
    kinds = zip(np.split(np.abs(change), ends), np.split(bound, ends), strict=True)
    tiny = np.finfo(float).tiny
    return max(float(kind.max() / max(limit.max(), tiny)) for kind, limit in kinds if kind.size)


def _record(
    samples: SampleSteps,
    pairs: Places,
    changes: Array,
    rows: Array,
    at_start: bool,
    band: Band | None,
) -> MotionDifference:
    """Returns the record of the `changes` at the rows of `pairs`, with the estimates, bounds, parts
    of the solver and uses of the band in `rows`, shape (4, n)."""
    times = samples.recording.times[pairs[:, 0]]
    degrees = samples.space.velocities
    differs = (changes != 0.0).any(axis=1)
    known = np.isfinite(rows[3]) & differs
    first = int(np.argmax(differs)) if differs.any() else None
    largest = int(np.argmax(np.where(known, rows[3], -1.0))) if known.any() else None
    return MotionDifference(
        times=times,
        sizes=np.abs(changes[:, :degrees]).max(axis=1),
        estimates=rows[0],
        bounds=rows[1],
        solver=rows[2],
        uses=rows[3],
        first=None if first is None else _at(samples, times[first], changes[first]),
        at_start=at_start,
        largest=None if largest is None else _at(samples, times[largest], changes[largest]),
        until=float(times[np.isfinite(rows[3])].max()),
        why=band.why if band else "",
        opened=band.opened if band else "",
    )


def _at(samples: SampleSteps, time: float, change: Array) -> SampleDifference:
    """Returns the difference at one sample, at the place where it is largest."""
    number = int(np.argmax(np.abs(change)))
    kind, index = divmod(number, samples.space.velocities)
    names = samples.steps.place_names
    place = names[index] if kind < 2 else f"activation {number - 2 * len(names)}"
    what = ("position", "velocity", "activation")[min(kind, 2)]
    return SampleDifference(float(time), place, what, abs(float(change[number])))
