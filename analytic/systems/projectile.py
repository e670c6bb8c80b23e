"""A thrown body that turns as it flies: a parabola.

With the speed v and the elevation e (Landau and Lifshitz 1976, Mechanics, 2),

    x = v t cos e,   z = v t sin e - g t^2/2,   angle = spin t                                  (1)

Semi-implicit Euler has the error -g h t/2 in z, exactly and at any step h, since each step falls at
the speed of its end. A scheme that moves before it accelerates has the error +g h t/2.
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
ROUNDINGS = 4.0  # roundings of each parameter in the uncertainty


@dataclass(frozen=True)
class Projectile(LinearResponse):
    """A body thrown from the origin at `speed` [m/s] and `elevation` [rad] above the level, turning
    at `spin` [rad/s], under `gravity` [m/s^2]. Raises ParameterError.

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
        """The exact motion: the projectile itself is a `Reference`."""
        return self

    @cached_property
    def system(self) -> SmoothSystem:
        """Eq. 1 as a smooth system, for the theory of time stepping."""
        along = self.speed * math.cos(self.elevation)
        up = self.speed * math.sin(self.elevation)
        return SmoothSystem(
            coordinates=OBSERVED,
            rates=tuple(f"{name}_dot" for name in OBSERVED),
            mass_matrix=lambda p, q: ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
            forces=lambda p, time, q, v: (0.0 * q[0], 0.0 * q[1] - p.gravity, 0.0 * q[2]),
            parameters={"gravity": self.gravity},
            position=(0.0, 0.0, 0.0),
            rate=(along, up, self.spin),
        )

    def observe(self, times: Array) -> Signals:
        """Exact coordinates and rates at `times` [s], shape (n,), by name: eq. 1 and its
        derivative."""
        system = self.system
        forces = system.forces(system.values, 0.0, system.position, system.rate)
        accelerations = np.array(forces)[:, None]
        rates = np.array(system.rate)[:, None] + accelerations * times
        coordinates = (rates - accelerations * times / 2) * times
        return system.observed(np.concatenate([coordinates, rates]))

    def uncertainty(self, times: Array) -> Signals:
        """Bound on the error of each observable, shape (n,), by the rounding of each parameter."""
        return rounded_inputs(self, lambda body: body.observe(times), ROUNDINGS)

    @property
    def apex(self) -> float:
        """Height of the highest point [m]; infinite without gravity."""
        up = max(self.speed * math.sin(self.elevation), 0.0)
        return up**2 / (2 * self.gravity) if self.gravity else math.inf

    def potential(self, observed: Signals) -> Any:
        """Returns the potential energy of 1 kg [J]."""
        return self.gravity * observed["z"]
