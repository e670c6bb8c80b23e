"""Cuts a run where it has diverged."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np

from plumbob.engines.trajectory import ByName, Trajectory


def within(trajectory: Trajectory, limits: ByName) -> Trajectory:
    """The trajectory up to the first sample at which the magnitude of an observable exceeds its
    limit or an observable is nan; `diverged_at` is the time of that sample."""
    lost = np.zeros(len(trajectory.times), dtype=bool)
    for name, values in trajectory.observables.items():
        lost |= ~(np.abs(values) <= limits.get(name, sys.float_info.max))
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
