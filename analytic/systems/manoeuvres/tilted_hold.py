"""A body at rest by static friction under tilted gravity, its slider fixed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.parameters import finite
from plumbob.analytic.reference import Array, LinearResponse
from plumbob.analytic.systems.capsule import (
    NORMAL_FORCES,
    Capsule,
    Point,
    Segment,
    by_support,
    normal_force_uncertainty,
    normal_forces,
    validity,
)
from plumbob.analytic.systems.capsule_motion import MotionKind, SingleMotion
from plumbob.analytic.systems.manoeuvres.residual_motion import ROUNDINGS
from plumbob.analytic.systems.manoeuvres.slow_motion import proper_fraction
from plumbob.analytic.systems.slider_path import SliderPath, fixed


def tilt_angle(capsule: Capsule, fraction: float = 1.0) -> float:
    """Tilt of gravity [rad] at which its tangential part is `fraction` of the friction limit:
    tan(alpha) = fraction f.

    Weight acts at the combined centre mu r, which is also the centre of pressure, so every support
    carries friction in proportion to N_i, and the threshold is the same in every direction and
    wherever Q is fixed (heights zero: the tilt moves no load). Raises ParameterError."""
    return math.atan(proper_fraction("fraction", fraction) * capsule.friction)


def tilted_gravity(capsule: Capsule, fraction: float, direction: float) -> Array:
    """Gravity [m/s^2], shape (3,), of unchanged magnitude, tilted by `tilt_angle` so as to pull
    along `direction` [rad, from the body's x axis]. Raises ParameterError."""
    angle, heading = tilt_angle(capsule, fraction), finite("direction", direction)
    down, along = math.cos(angle), math.sin(angle)
    pull = np.array([along * math.cos(heading), along * math.sin(heading), -down])
    return capsule.gravity * pull


@dataclass(frozen=True)
class TiltedHold(SingleMotion, LinearResponse):
    """Body at rest under gravity tilted along `direction` [rad], by `fraction` of the threshold,
    with Q fixed at `slider` relative to C [m]. Raises ParameterError."""

    capsule: Capsule
    fraction: float
    direction: float = 0.0
    slider: Point = (0.0, 0.0)
    kind: ClassVar[MotionKind] = "hold"
    sliding_time: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        tilted_gravity(self.capsule, self.fraction, self.direction)
        for breach in validity(self.capsule, (Segment(self.slider, self.slider),)):
            raise breach

    @property
    def path(self) -> SliderPath:
        """The fixed slider."""
        return fixed(self.slider)

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Exact observables at `times` [s], shape (n,): nothing moves; friction balances the
        tangential part of the weight (signed along `direction`), the N_i the normal part."""
        still = np.zeros_like(np.asarray(times, dtype=np.float64))
        angle = tilt_angle(self.capsule, self.fraction)
        forces = math.cos(angle) * normal_forces(self.capsule, np.array([self.slider]))[0]
        names = ("displacement", "velocity", "heading", "sideways", "stroke", "stroke_rate")
        return {
            **dict.fromkeys(names, still),
            **by_support(still[:, None] + forces),
            "friction_force": still - self.capsule.weight * math.sin(angle),
            "driving_force": still
            - self.capsule.mass_ratio * self.capsule.weight * math.sin(angle),
        }

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Absolute error [SI] at `times` [s], shape (n,), of forces; rest is exact."""
        slack = normal_force_uncertainty(self.capsule, math.hypot(*self.slider))
        few = ROUNDINGS * ROUNDOFF * self.capsule.weight
        forces = dict.fromkeys(NORMAL_FORCES, slack)
        forces |= {"friction_force": few, "driving_force": self.capsule.mass_ratio * few}
        return {
            name: np.zeros_like(value) + forces.get(name, 0.0)
            for name, value in self.observe(times).items()
        }
