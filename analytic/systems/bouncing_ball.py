"""A ball that is dropped and bounces off a floor. Each impact leaves the same fraction of its
speed.

With e the coefficient of restitution and t_1 = sqrt(2 h/g) (Falcon et al. 1998, Eur. Phys. J. B 3,
45, eqs. 1-3), impact n is at the time

    t_n = t_1 (1 + 2 (e + ... + e^(n-1))).

The ball leaves it with the speed e^n g t_1. All impacts end at t_inf = t_1 (1 + e)/(1 - e).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF, ULP, rounded_inputs
from plumbob.analytic.parameters import ParameterError, check_fields
from plumbob.analytic.reference import Array, LinearResponse, Signals

ROUNDINGS = 8.0  # roundings of each parameter in the uncertainty
TINY = 1e-300  # restitution in place of 0: its speeds are too small to matter


@dataclass(frozen=True)
class BouncingBall(LinearResponse):
    """A ball dropped from rest with its lowest point `height` [m] above a floor, under `gravity`
    [m/s^2], with a coefficient of `restitution` from 0 to 1. Raises ParameterError.

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
        """Time [s] at which the infinite sequence of impacts ends; infinite if e = 1."""
        e = self.restitution
        return self.fall * (1.0 + e) / (1.0 - e) if e < 1.0 else math.inf

    @property
    def _inner_restitution(self) -> float:
        """The restitution e, replaced by a neighbouring number if it is 0 or 1."""
        return min(max(self.restitution, TINY), 1.0 - ROUNDOFF)

    def impacts(self, counts: Array) -> tuple[Array, Array]:
        """Returns the times [s] of the impacts with the numbers `counts`, from 1 on, shape (n,),
        and the peak heights [m] of the flights that follow."""
        # The sum e + ... + e^(n-1) in closed form, without cancellation near e = 1.
        e = self._inner_restitution
        power_sum = -e * np.expm1((counts - 1.0) * math.log(e)) / (1.0 - e)
        return self.fall * (1.0 + 2.0 * power_sum), self.height * e ** (2.0 * counts)

    def _flight(self, times: Array) -> tuple[Array, Array]:
        """Returns the time [s] since the last impact and the speed after it [m/s], shape (n,) each.
        Before the first impact they are the time since the start, and 0. When the ball is at rest
        they have no meaning."""
        e = self._inner_restitution
        relative_times = times / self.fall
        with np.errstate(all="ignore"):
            # 1 + left = (t_inf - t) (1 - e)/(2 t_1), which is e^n at impact n.
            left = -(1.0 - e) * (1.0 + relative_times) / 2.0
            counts = np.floor(np.log1p(left) / math.log(e))
            counts = np.maximum(np.where(relative_times < 1.0, 0.0, counts), 0.0)
            # Rounding may have changed the number by one.
            counts += self.impacts(counts + 1.0)[0] <= times
            counts -= (counts > 0.0) & (self.impacts(counts)[0] > times)
        last_impact = np.where(counts > 0.0, self.impacts(counts)[0], 0.0)
        speed = np.where(counts > 0.0, self.gravity * self.fall * e**counts, 0.0)
        return times - last_impact, speed

    def observe(self, times: Array) -> Signals:
        """Exact height z [m] of the lowest point at `times` [s], shape (n,)."""
        since, speed = self._flight(times)
        start = np.where(times < self.fall, self.height, 0.0)
        z = start + since * (speed - self.gravity * since / 2.0)
        bouncing = np.nan_to_num(np.maximum(z, 0.0))
        return {"z": np.where(times < self.zeno_time, bouncing, 0.0)}

    def uncertainty(self, times: Array) -> Signals:
        """Bound on the error of each observable, shape (n,), by the rounding of each parameter and
        of a height."""
        errors = rounded_inputs(self, lambda ball: ball.observe(times), ROUNDINGS)
        return {"z": errors["z"] + ULP * self.height}
