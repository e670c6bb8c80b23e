"""Sensitivities of the capsule's motions: from event to event, or by formula in phases."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.sensitivities.neighbours import Neighbours, Sensitivity
from plumbob.analytic.sensitivities.phases import Phased, phased_gradients
from plumbob.analytic.sensitivities.sliding_motion import SlidingBody, sliding_gradients
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.slider_path import fixed
from plumbob.analytic.systems.three_points.friction import Start, three_point_motion
from plumbob.analytic.systems.three_points.motion import ThreePointMotion


def capsule_gradients(
    problems: Sequence[Neighbours[CapsuleProblem]], times: Array
) -> list[Sensitivity]:
    """Sensitivities at `times` [s], shape (n,), by each parameter."""
    motion = problems[0].here.motion
    if motion.kind in ("plane", "coasting") and motion.count == 1:
        return sliding_gradients([one.each(sliding_body) for one in problems], times)
    return phased_gradients([one.each(phased) for one in problems], times)


def sliding_body(problem: CapsuleProblem) -> SlidingBody:
    """A motion in the plane; one with a formula too, whose neighbours may have none."""
    setup, motion = problem.setup, problem.motion.single
    if not isinstance(motion, ThreePointMotion):
        begun = Start(velocity=setup.velocity, angular_velocity=setup.heading_rate)
        motion = three_point_motion(setup.capsule, fixed(setup.slider), begun)
    velocity = complex(*setup.velocity)
    return SlidingBody(motion, setup.heading, velocity, setup.heading_rate)


def phased(problem: CapsuleProblem) -> Phased:
    """A motion with a formula; it changes where the slider's acceleration does, and where the body
    stops, or its mode changes."""
    motion, single = problem.motion, problem.motion.single
    stops = np.array([single.sliding_time])
    if isinstance(single, ThreePointMotion):
        stops = np.array([event.time for event in single.events])
    if motion.count > 1:
        stops = (motion.period * np.arange(motion.count)[:, None] + stops).ravel()
    switches = np.concatenate([motion.path.breakpoints, stops[np.isfinite(stops)]])
    return Phased(problem.in_world, np.sort(switches))
