"""A body that is thrown, and turns as it flies: a parabola.

With the speed v and the elevation e (Landau and Lifshitz 1976, Mechanics, 2),

    x = v t cos e,   z = v t sin e - g t^2/2,   angle = spin t                                  (1)

Semi-implicit Euler adds -g h t/2 to z, since each step falls at the speed of its end, and a step
that moves before it accelerates +g h t/2: exactly, at any step h.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.parameters import check_fields
from plumbob.analytic.reference import Array, LinearResponse

OBSERVED = ("x", "z", "angle")
ROUNDINGS = 4.0  # of inputs and operations, in units in the last place of each term


@dataclass(frozen=True)
class Parabola(LinearResponse):
    """The motion of a `system` under gravity alone (eq. 1); a `Reference`."""

    system: SmoothSystem

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Coordinates and rates at `times` [s], shape (n,), by name."""
        thrown, fallen = self._terms(times)
        return self.system.observed(thrown + fallen)

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Effect of rounding, shape (n,): of speed, angles, times and operations."""
        thrown, fallen = self._terms(times)
        return self.system.observed(ROUNDINGS * ULP * (np.abs(thrown) + np.abs(fallen)))

    def _terms(self, times: Array) -> tuple[Array, Array]:
        """The terms of eq. 1 and of its derivative, shape (6, n) each."""
        system, start = self.system, (self.system.position, self.system.rate)
        fall = np.array(system.acceleration(0.0, *start, system.values))[:, None]
        rates = np.array(system.rate)[:, None]
        thrown = np.concatenate([rates * times, rates + 0.0 * times])
        return thrown, np.concatenate([fall * np.square(times) / 2, fall * times])


@dataclass(frozen=True)
class Projectile:
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

    @cached_property
    def motion(self) -> Parabola:
        """The exact motion."""
        along, up = (self.speed * f(self.elevation) for f in (math.cos, math.sin))
        return Parabola(
            SmoothSystem(
                OBSERVED,
                tuple(f"{name}_dot" for name in OBSERVED),
                lambda p, q: ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
                lambda p, time, q, v: (0.0 * q[0], 0.0 * q[1] - p.gravity, 0.0 * q[2]),
                {"gravity": self.gravity},
                (0.0, 0.0, 0.0),
                (along, up, self.spin),
            )
        )

    @property
    def apex(self) -> float:
        """Height of the highest point [m], infinite without gravity."""
        up = max(self.speed * math.sin(self.elevation), 0.0)
        return up**2 / (2 * self.gravity) if self.gravity else math.inf

    def potential(self, observed: Mapping[str, Array]) -> Any:
        """Potential energy of 1 kg [J]."""
        return self.gravity * observed["z"]
