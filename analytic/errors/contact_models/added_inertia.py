"""Errors from inertia that an engine adds to a model.

A slider's joint of armature A that a motor of gear A drives follows its control but for m/A of what
else accelerates the slider. A pendulum's bob of moment of inertia I, meant to be a point, is like
a mass m l^2 that is larger by I.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import NORMAL_FORCES, ROUNDOFF, load_slopes
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre, condition_number

DRIVE_ROUNDINGS = 16  # of what drives the slider's joint
TIME_ROUNDINGS = 4  # of the times at which its velocity is evaluated, at most the duration
POINTS = 200  # samples of a pendulum's motion


@lru_cache(maxsize=64)  # the same for every method and step of a scene
def bob_error(problem: Any, duration: float, moment_ratio: float) -> Mapping[str, float]:
    """Bounds on the observables of a SimplePendulum over `duration` [s] whose bob's moment of
    inertia is `moment_ratio` of m l^2: at most the effect of as many units in the last place of
    every parameter as it has."""
    doubts = problem.motion.uncertainty(np.linspace(0.0, duration, POINTS))
    return {
        name: moment_ratio / (2 * ROUNDOFF) * float(doubt.max()) for name, doubt in doubts.items()
    }


def slider_on_a_line(
    problem: CapsuleProblem,
    times: Array,
    armature: float,
    step: float,
    line: LineManoeuvre | None,
    count: int,
) -> Mapping[str, float]:
    """Bounds where the slider's way in the body lacks m/A of its way in space, at `times` [s],
    shape (n,), for an `armature` [kg] and steps of `step` [s]; of `count` manoeuvres `line` where
    the motion is these."""
    setup, duration = problem.setup, float(times[-1])
    part, mu = setup.capsule.slider_mass / armature, setup.capsule.mass_ratio
    observed = problem.reference.observe(times)
    way = float((np.abs(observed["stroke"]) + np.abs(observed["displacement"])).max())
    rate = float((np.abs(observed["stroke_rate"]) + np.abs(observed["velocity"])).max())
    moved, left = 0.0, 0.0
    if line is not None:
        moved = condition_number(line) * abs(line.displacement) * count
        # The velocity that is left when the times are rounded.
        left = TIME_ROUNDINGS * ROUNDOFF * duration * line.w1
    slid = part * way + left * duration
    slope = float(np.abs(load_slopes(setup.capsule, setup.direction)).max())
    driven = (part + DRIVE_ROUNDINGS * ROUNDOFF) * rate
    # Friction that stops the body takes its velocity in a step; where there is none it is rounding.
    stopped = driven if setup.capsule.friction else DRIVE_ROUNDINGS * ROUNDOFF * rate
    # The lag of the slider grows with its acceleration in space, F/m; rounding recurs every step.
    lagging = part * float(np.abs(observed["driving_force"]).max())
    lagging += 2.0 * DRIVE_ROUNDINGS * ROUNDOFF * rate * setup.capsule.slider_mass / step
    friction = setup.capsule.slider_mass * stopped / step
    return {
        "stroke": slid,
        "stroke_rate": driven,
        "driving_force": mu * friction + (1.0 - mu) * lagging,
        "displacement": part * moved,
        "velocity": mu * driven,  # while it slides: the reaction is m/(M + m) of the acceleration
        "friction_force": friction,
        **dict.fromkeys(NORMAL_FORCES, slid * slope),
    }


def slider_in_the_plane(
    slider_mass: float, armature: float, times: Array, speeds: Array
) -> tuple[float, float]:
    """Bounds on a slider's way [m] and velocity [m/s] in the body, and on the body's, where its
    speeds in space are at most `speeds` [m/s], shape (n,), at `times` [s], shape (n,)."""
    part = slider_mass / armature + DRIVE_ROUNDINGS * ROUNDOFF
    return part * float(np.trapezoid(speeds, times)), part * float(speeds.max())
