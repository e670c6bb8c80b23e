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
CLOSE = 0.1
# Largest relative difference between sliding times if all supports stop together. Supports of a
# neighbour then stop one by one, which makes an error of first order in this difference.
TOGETHER = 1e-6


def capsule_gradients(
    problems: Sequence[Neighbours[CapsuleProblem]], times: Array
) -> list[Sensitivity]:
    """Returns the sensitivities at `times` [s], shape (n,), by each parameter; `problems` has the
    neighbours by one parameter each."""
    moved = partial(phased, together=problems[0].here.motion.kind == "coasting")
    return phased_gradients([one.each(moved) for one in problems], times)


def phased(problem: CapsuleProblem, together: bool = False) -> Phased:
    """Returns the motion of a problem with the times at which its formula changes.

    The formula changes with the slider's acceleration, with the mode of the supports, and when the
    body stops. If all supports of the unchanged motion stop `together`, a neighbour pivots at its
    end, for a time that is small in the difference. These short phases are then left out.
    """
    motion = problem.motion
    single = problem.motion.single
    own = problem.reference
    if isinstance(own, PlaneReference):
        own = replace(own, sure=1.0)
    in_world = InWorld(own, problem.setup.heading)
    if isinstance(single, ThreePointMotion) and not together:
        return Phased(in_world, _repeated(motion, _phases(single)[1]))
    stops = _repeated(motion, np.array([single.sliding_time]))
    switches = np.append(motion.path.breakpoints, stops[np.isfinite(stops)])
    return Phased(in_world, np.sort(switches))


def alike(problem: CapsuleProblem, near: CapsuleProblem) -> bool:
    """Returns whether a problem and its neighbour `near` have the same phases of nearly equal
    lengths."""
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
    first = [True] + [
        left[::2] != right[::2] or right[1] not in ((-1,) if right[0] == "slide" else left[1:2])
        for left, right in pairwise(names)
    ]
    return list(compress(names, first)), motion.begins[first]
