"""The slider's prescribed acceleration as a control: its mean over each step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from analytic.reference import Array
from models.tripod_capsule.staging import Staging


def control(staging: Staging, step: float) -> Callable[[Array], Array] | None:
    """Times at which steps of `step` [s] begin, shape (n,) -> ctrl [m/s^2], shape (n, 1).

    Held over the step, the mean brings the slider's velocity to where it should be at every grid
    time, whether or not the acceleration switches inside a step; its value at mid-step does the
    manoeuvre of the nearest switch on the grid, an error of first order.
    """
    if (velocity := staging.relative_velocity) is None:
        return None

    def mean(times: Array) -> Array:
        # By index: the velocity that one step ends with is the one that the next begins with.
        first = np.rint(times / step)
        edges = np.stack([first, first + 1.0]) * step
        return np.asarray(np.diff(velocity(edges), axis=0)[0] / step)[:, None]

    return mean
