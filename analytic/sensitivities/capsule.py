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

# Relative difference of lengths of phases, beyond which a stencil is not accurate: nearer
# neighbours than that have the motion's own uncertainty over a smaller difference.
CLOSE = 0.1
TOGETHER = 1e-6  # likewise, where supports that stop together then do not: of first order in it


def capsule_gradients(
    problems: Sequence[Neighbours[CapsuleProblem]], times: Array
) -> list[Sensitivity]:
    """Sensitivities at `times` [s], shape (n,), by each parameter."""
    moved = partial(phased, together=problems[0].here.motion.kind == "coasting")
    return phased_gradients([one.each(moved) for one in problems], times)


def phased(problem: CapsuleProblem, together: bool = False) -> Phased:
    """The motion; its formula changes where the slider's acceleration does, and where the body
    stops, or its mode changes. Near a motion in which all supports stop `together` others pivot at
    the end, for a time that is small in the difference."""
    motion = problem.motion
    single = problem.motion.single
    own = problem.reference
    if isinstance(own, PlaneReference):
        own = replace(own, error_factor=1.0)
    in_world = InWorld(own, problem.setup.heading)
    if isinstance(single, ThreePointMotion) and not together:
        return Phased(in_world, _repeated(motion, _phases(single)[1]))
    stops = _repeated(motion, np.array([single.sliding_time]))
    switches = np.append(motion.path.breakpoints, stops[np.isfinite(stops)])
    return Phased(in_world, np.sort(switches))


def alike(problem: CapsuleProblem, near: CapsuleProblem) -> bool:
    """Whether a problem `near` another has the same phases, of nearly the same lengths."""
    here = problem.motion.single
    there = near.motion.single
    if not isinstance(here, ThreePointMotion):
        formula = not isinstance(there, ThreePointMotion)
        return formula or bool(abs(there.sliding_time / here.sliding_time - 1.0) < TOGETHER)
    if not isinstance(there, ThreePointMotion):
        return False
    (names, begins) = _phases(here)
    (others, later) = _phases(there)
    return names == others and np.allclose(np.diff(later), np.diff(begins), CLOSE, 0.0)


def _repeated(motion: Any, times: Array) -> Array:
    """Times [s] in one motion as those in all its repetitions."""
    if motion.count == 1:
        return times
    return np.asarray((motion.period * np.arange(motion.count)[:, None] + times).ravel())


def _phases(motion: ThreePointMotion) -> tuple[list[tuple[str, int, int]], Array]:
    """Mode, support and number of the slider's piece in each phase, and when it begins [s]."""
    names = [
        (segment.mode, segment.support, segment.interval.number) for segment in motion.segments
    ]
    first = [True] + [
        left[::2] != right[::2] or right[1] not in ((-1,) if right[0] == "slide" else left[1:2])
        for left, right in pairwise(names)
    ]
    return list(compress(names, first)), motion.begins[first]
