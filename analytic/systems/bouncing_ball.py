"""A ball that is dropped and bounces off a floor, each time with the same part of its speed.

With e the coefficient of restitution and t_1 = sqrt(2 h/g) (Falcon et al. 1998, Eur. Phys. J. B 3,
45, eqs. 1-3), impact n is at

    t_n = t_1 (1 + 2 (e + ... + e^(n-1))),   it leaves with e^n g t_1,   and all end at
    t_inf = t_1 (1 + e)/(1 - e).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF, ULP, rounded_inputs
from plumbob.analytic.parameters import ParameterError, check_fields
from plumbob.analytic.reference import Array, LinearResponse, Signals

ROUNDINGS = 8.0  # of each parameter
TINY = 1e-300  # of a speed: no double shows it


@dataclass(frozen=True)
class BouncingBall(LinearResponse):
    """A ball dropped from rest with its lowest point `height` [m] above a floor, under `gravity`
    [m/s^2], with a coefficient of `restitution` from 0 to 1; raises ParameterError.

    >>> BouncingBall(1.0, 0.5, 9.81).zeno_time
    1.3545709229571927
    """

    height: float
    restitution: float
    gravity: float

    def __post_init__(self) -> None:
        check_fields(self, ("height", "gravity"), ("restitution",))
        if self.restitution > 1.0:
            raise ParameterError("restitution", self.restitution, "from 0 to 1")

    @property
    def fall(self) -> float:
        """Time of the first impact [s]."""
        return math.sqrt(2.0 * self.height / self.gravity)

    @property
    def zeno_time(self) -> float:
        """Time [s] at which the last of infinitely many impacts is over; infinite for e = 1."""
        e = self.restitution
        return self.fall * (1.0 + e) / (1.0 - e) if e < 1.0 else math.inf

    @property
    def _within(self) -> float:
        """e, or next to it where it is 0 or 1."""
        return min(max(self.restitution, TINY), 1.0 - ROUNDOFF)

    def impacts(self, counts: Array) -> tuple[Array, Array]:
        """Times [s] of the impacts of these numbers, from 1 on, shape (n,), and heights [m] of the
        flights that follow."""
        # e (1 - e^(n-1))/(1 - e): no term of a sum is lost near e = 1
        e = self._within
        between = -e * np.expm1((counts - 1.0) * math.log(e)) / (1.0 - e)
        return self.fall * (1.0 + 2.0 * between), self.height * e ** (2.0 * counts)

    def _flight(self, times: Array) -> tuple[Array, Array]:
        """Time [s] since the last impact, or the top before the first, and the speed then [m/s]; no
        number at rest."""
        e = self._within
        begun = times / self.fall
        with np.errstate(all="ignore"):
            left = -(1.0 - e) * (1.0 + begun) / 2.0  # e^n is what is left of the time to t_inf
            counts = np.floor(np.log1p(left) / math.log(e))
            counts = np.maximum(np.where(begun < 1.0, 0.0, counts), 0.0)
            counts += self.impacts(counts + 1.0)[0] <= times  # rounding may be one impact off
            counts -= (counts > 0.0) & (self.impacts(counts)[0] > times)
        since = times - np.where(counts > 0.0, self.impacts(counts)[0], 0.0)
        return since, np.where(counts > 0.0, self.gravity * self.fall * e**counts, 0.0)

    def observe(self, times: Array) -> Signals:
        """Height z [m] of the lowest point at `times` [s], shape (n,)."""
        since, speed = self._flight(times)
        flown = np.where(times < self.fall, self.height, 0.0)
        z = flown + since * (speed - self.gravity * since / 2.0)
        return {"z": np.where(times < self.zeno_time, np.nan_to_num(np.maximum(z, 0.0)), 0.0)}

    def uncertainty(self, times: Array) -> Signals:
        """Absolute errors, shape (n,): the effect of each parameter's rounding and a height's."""
        doubts = rounded_inputs(self, lambda ball: ball.observe(times), ROUNDINGS)
        return {"z": doubts["z"] + ULP * self.height}
