"""Errors of fixed steps on plane motions, by taking the steps (THEORY.md, section 7)."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.sliding_motion.plane_steps import COLUMNS, trajectory
from plumbob.analytic.errors.sliding_motion.position_first import position_first_trajectory
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.systems.capsule import by_support, normal_forces
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.analytic.systems.three_points.reference import PlaneReference
from plumbob.analytic.theory import Errors, apart

MOST_STEPS = 200_000  # each takes some tens of microseconds


def plane_errors(reference: PlaneReference, scheme: Scheme, step: float, times: Array) -> Errors:
    """Error that steps of `step` [s] make of the motion at grid `times` [s], shape (n,), by
    observable of `PlaneReference`, found by taking them (`errors.plane_steps`,
    `errors.position_first`); empty for other schemes, or more than MOST_STEPS steps."""
    times = np.asarray(times, dtype=np.float64)
    marks = np.rint(times / step).astype(np.int64)
    steps, motion = int(marks.max()), reference.motion
    if steps > MOST_STEPS or scheme.position_lead is None:
        return {}
    driven = (motion.capsule, motion.path, reference.begun)
    if scheme.position_first:
        rows = position_first_trajectory(*driven, step, steps)[marks]
    else:
        rows = trajectory(*driven, scheme.integrator, step, steps)[marks]
    stepped = dict(zip(COLUMNS, rows.T, strict=True))
    stepped["body_angle"] = stepped["heading"]
    if not scheme.position_first:
        places = held_places(motion.path, float(scheme.position_lead), step, steps)[marks]
        stepped |= by_support(normal_forces(motion.capsule, places))
    return apart(stepped, reference.observe(times))


def held_places(path: SliderPath, lead: float, step: float, steps: int) -> Array:
    """Places of the slider [m], shape (steps + 1, 2), whose velocity is right at grid times: sums
    of it, each step of `step` [s] with the part 1/2 + `lead` of that at its end."""
    places, speeds, _ = path.kinematics(np.arange(steps + 1, dtype=np.float64) * step)
    mean = (0.5 - lead) * speeds[:-1] + (0.5 + lead) * speeds[1:]
    return np.vstack([places[:1], places[0] + step * np.cumsum(mean, axis=0)])
