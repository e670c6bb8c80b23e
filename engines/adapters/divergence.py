"""Where a trajectory stops being one: what is beyond the reach of the motion is cut off."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.engines.trajectory import Trajectory

BEYOND = 10.0  # times what is possible: wrong that far is diverged, less far is an error to measure


def possible_speed(rotor: DrivenRotor, theta_dot: float) -> float:
    """A speed [rad/s] that a conservative `rotor` started at `theta_dot` [rad/s] never exceeds."""
    span = abs(rotor.sin2) + 2 * abs(rotor.cos) + 2 * abs(rotor.sin)  # of V, at most
    return float(np.sqrt(theta_dot**2 + 2 * span))


def within(trajectory: Trajectory, limits: Mapping[str, float]) -> Trajectory:
    """`trajectory` up to the first sample at which an observable exceeds its limit in magnitude,
    or is not a number; `diverged_at` then says when."""
    lost = np.zeros(len(trajectory.times), dtype=bool)
    for name, values in trajectory.observables.items():
        lost |= ~(np.abs(values) <= limits.get(name, np.inf)) | ~np.isfinite(values)
    if not lost.any():
        return trajectory
    first = int(np.argmax(lost))
    return replace(
        trajectory,
        times=trajectory.times[:first],
        observables={name: values[:first] for name, values in trajectory.observables.items()},
        channels={name: values[:first] for name, values in trajectory.channels.items()},
        diverged_at=float(trajectory.times[first]),
    )
