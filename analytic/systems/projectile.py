"""A body that is thrown, and turns as it flies: a parabola.

With the speed v and the elevation e (Landau and Lifshitz 1976, Mechanics, 2),

    x = v t cos e,   z = v t sin e - g t^2/2,   angle = spin t                                  (1)

Semi-implicit Euler adds -g h t/2 to z, since each step falls at the speed of its end, and a step
that moves before it accelerates +g h t/2: exactly, at any step h.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import rounded_inputs
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.parameters import check_fields
from plumbob.analytic.reference import Array, LinearResponse, Signals

OBSERVED = ("x", "z", "angle")
ROUNDINGS = 4.0  # of each parameter


@dataclass(frozen=True)
class Projectile(LinearResponse):
    """A body thrown from the origin at `speed` [m/s] and `elevation` [rad] above the level, turning
    at `spin` [rad/s], under `gravity` [m/s^2]; raises ParameterError.

    >>> round(Projectile(10.0, 0.5, 0.0, 9.81).apex, 6)
    1.171503
    """

    speed: float
    elevation: float
    spin: float
    gravity: float

    def __post_init__(self) -> None:
        check_fields(self, (), ("speed", "gravity"))

    @property
    def motion(self) -> Projectile:
        """Its exact motion is its own."""
        return self

    @cached_property
    def system(self) -> SmoothSystem:
        """Eq. 1 as theory steps it."""
        along, up = (self.speed * f(self.elevation) for f in (math.cos, math.sin))
        return SmoothSystem(
            OBSERVED,
            tuple(f"{name}_dot" for name in OBSERVED),
            lambda p, q: ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
            lambda p, time, q, v: (0.0 * q[0], 0.0 * q[1] - p.gravity, 0.0 * q[2]),
            {"gravity": self.gravity},
            (0.0, 0.0, 0.0),
            (along, up, self.spin),
        )

    def observe(self, times: Array) -> Signals:
        """Coordinates and rates at `times` [s], shape (n,), by name: eq. 1 and its derivative."""
        system = self.system
        fall = np.array(system.forces(system.values, 0.0, system.position, system.rate))[
            :, None
        ]
        rates = np.array(system.rate)[:, None] + fall * times
        return system.observed(np.concatenate([(rates - fall * times / 2) * times, rates]))

    def uncertainty(self, times: Array) -> Signals:
        """Absolute errors, shape (n,), by the effect of each parameter's rounding."""
        return rounded_inputs(self, lambda body: body.observe(times), ROUNDINGS)

    @property
    def apex(self) -> float:
        """Height of the highest point [m], infinite without gravity."""
        up = max(self.speed * math.sin(self.elevation), 0.0)
        return up**2 / (2 * self.gravity) if self.gravity else math.inf

    def potential(self, observed: Signals) -> Any:
        """Potential energy of 1 kg [J]."""
        return self.gravity * observed["z"]
