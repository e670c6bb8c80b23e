"""Sensitivities of the capsule's motions, in phases between events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import compress, pairwise
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.sensitivities.neighbours import Neighbours, Sensitivity
from plumbob.analytic.sensitivities.phases import Phased, phased_gradients
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, InWorld
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.analytic.systems.three_points.reference import PlaneReference

# Largest relative difference between the lengths of a phase in two neighbours. A stencil with a
# larger difference is not accurate. Closer neighbours would not help: they divide the motion's own
# uncertainty by a smaller difference.
PHASE_LENGTH_DIFFERENCE = 0.1
# Largest relative difference between sliding times if all supports stop together. Supports of a
# neighbour then stop one by one, which makes an error of first order in this difference.
SIMULTANEOUS_STOP_DIFFERENCE = 1e-6


def capsule_gradients(
    problems: Sequence[Neighbours[CapsuleProblem]], times: Array
) -> list[Sensitivity]:
    """Returns the sensitivities at `times` [s], shape (n,), by each parameter; `problems` has the
    neighbours by one parameter each."""
    phases = partial(phased_motion, together=problems[0].here.motion.kind == "coasting")
    return phased_gradients([neighbours.each(phases) for neighbours in problems], times)


def phased_motion(problem: CapsuleProblem, together: bool = False) -> Phased:
    """Returns the motion of a problem with the times at which its formula changes.

    The formula changes with the slider's acceleration, with the mode of the supports, and when the
    body stops. If all supports of the unchanged motion stop `together`, a neighbour pivots at its
    end, for a time that is small in the difference. These short phases are then left out.
    """
    motion = problem.motion
    single = problem.motion.single
    reference = problem.reference
    if isinstance(reference, PlaneReference):
        reference = replace(reference, error_factor=1.0)
    in_world = InWorld(reference, problem.setup.heading)
    if isinstance(single, ThreePointMotion) and not together:
        _, begins = _phases(single)
        return Phased(in_world, _repeated_times(motion, begins))
    stops = _repeated_times(motion, np.array([single.sliding_time]))
    switches = np.append(motion.path.breakpoints, stops[np.isfinite(stops)])
    return Phased(in_world, np.sort(switches))


def alike(problem: CapsuleProblem, near: CapsuleProblem) -> bool:
    """Returns whether a problem and its neighbour `near` have the same phases of nearly equal
    lengths."""
    here = problem.motion.single
    there = near.motion.single
    if not isinstance(here, ThreePointMotion):
        if not isinstance(there, ThreePointMotion):
            return True
        difference = abs(there.sliding_time / here.sliding_time - 1.0)
        return bool(difference < SIMULTANEOUS_STOP_DIFFERENCE)
    if not isinstance(there, ThreePointMotion):
        return False
    names, begins = _phases(here)
    near_names, near_begins = _phases(there)
    if names != near_names:
        return False
    return np.allclose(np.diff(near_begins), np.diff(begins), PHASE_LENGTH_DIFFERENCE, 0.0)


def _repeated_times(motion: Any, times: Array) -> Array:
    """Returns the `times` [s] in one manoeuvre together with the same times in its repetitions."""
    if motion.count == 1:
        return times
    return np.asarray((motion.period * np.arange(motion.count)[:, None] + times).ravel())


def _phases(motion: ThreePointMotion) -> tuple[list[tuple[str, int, int]], Array]:
    """Returns the name of each phase and the time [s] at which it begins.

    A name is the mode, the support and the number of the slider's piece.
    """
    names = [
        (segment.mode, segment.support, segment.interval.number) for segment in motion.segments
    ]
    begins_phase = [True]
    for before, after in pairwise(names):
        begins_phase.append(not _continues(before, after))
    return list(compress(names, begins_phase)), motion.begins[begins_phase]


def _continues(before: tuple[str, int, int], after: tuple[str, int, int]) -> bool:
    """Returns whether a segment named `after` belongs to the phase of the segment `before` it."""
    mode_before, support_before, piece_before = before
    mode, support, piece = after
    if (mode_before, piece_before) != (mode, piece):
        return False
    return support == (-1 if mode == "slide" else support_before)
