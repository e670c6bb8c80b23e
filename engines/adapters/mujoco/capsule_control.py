"""The slider's prescribed acceleration as a control: its mean over each step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleSetup


def control(setup: CapsuleSetup, step: float) -> Callable[[Array], Array] | None:
    """Times at which steps of `step` [s] begin, shape (n,) -> ctrl [m/s^2], shape (n, 1), or (n, 2)
    in the axes of the body where the slider leaves its line.

    Held over the step, the mean brings the slider's velocity to where it should be at every grid
    time, whether or not the acceleration switches inside a step; its value at mid-step does the
    manoeuvre of the nearest switch on the grid, an error of first order.
    """
    if (velocity := _velocity(setup)) is None:
        return None

    def mean(times: Array) -> Array:
        # By index: the velocity that one step ends with is the one that the next begins with.
        first = np.rint(times / step)
        begun, ended = np.split(velocity(np.concatenate([first, first + 1.0]) * step), 2)
        return np.asarray((ended - begun) / step)

    return mean


def _velocity(setup: CapsuleSetup) -> Callable[[Array], Array] | None:
    """Imposed velocity [m/s] at times [s], shape (n,), by its components: (n, 1) or (n, 2)."""
    if (line := setup.relative_velocity) is not None:
        return lambda times: line(times)[:, None]
    return setup.plane_velocity
