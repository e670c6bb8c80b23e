"""A body that friction holds between two fingers: nothing moves.

In the frame of the hand, each finger presses with N along the normal and holds half of the load F =
|(push, m (g + lift))| across it. Friction holds the load while F <= 2 f N (Coulomb 1785).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.parameters import ParameterError, check_fields
from plumbob.analytic.reference import Array, LinearResponse, Signals


@dataclass(frozen=True)
class Pinch(LinearResponse):
    """A cube of edge `size` [m] and `mass` [kg] between two fingers of `finger_mass` [kg] each,
    which press with `normal_force` [N] and have a coefficient of `friction`. `gravity` [m/s^2] and
    a horizontal force `push` [N] across the fingers act on it, and the hand accelerates upward by
    `lift` [m/s^2]. Raises ParameterError, also if friction does not hold the cube.

    >>> Pinch(1.0, 0.05, 0.1, 0.5, 20.0, 10.0).fraction
    0.5
    """

    mass: float
    size: float
    finger_mass: float
    friction: float
    normal_force: float
    gravity: float
    push: float = 0.0
    lift: float = 0.0

    def __post_init__(self) -> None:
        positives = "mass", "size", "finger_mass", "friction", "normal_force", "gravity"
        check_fields(self, positives)
        if self.fraction > 1.0:
            least = self.load / (2.0 * self.friction)
            need = f"{least:.6g} N or more, or the body slips"
            raise ParameterError("normal_force", self.normal_force, need)

    @property
    def pull(self) -> Array:
        """The load that friction holds, downward and across [N], shape (2,)."""
        return np.array([self.mass * (self.gravity + self.lift), self.push])

    @property
    def load(self) -> float:
        """Magnitude of the load [N]."""
        return math.hypot(*self.pull)

    @property
    def fraction(self) -> float:
        """The ratio of the load to the largest friction."""
        return self.load / (2.0 * self.friction * self.normal_force)

    def observe(self, times: Array) -> Signals:
        """Slip [m] along the load and its rate, `speed` [m/s], at `times` [s], shape (n,): both are
        0."""
        zeros = np.zeros(len(times))
        return {"slip": zeros, "speed": zeros}

    def uncertainty(self, times: Array) -> Signals:
        """Returns the uncertainty of each observable, shape (n,). The exact motion is rest, so that
        the uncertainty is a scale of rounding: one unit in the last place of the edge length [m],
        and of the speed that a body gains over this length [m/s]."""
        slip = np.full(len(times), ULP * self.size)
        return {"slip": slip, "speed": slip * math.sqrt(self.load / self.mass / self.size)}
