"""A body held at rest by static friction under tilted gravity, with its slider fixed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from plumbob.analytic.parameters import finite
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule, PlanePoint, check_loads, normal_forces
from plumbob.analytic.systems.capsule_motion import MotionKind, SingleMotion
from plumbob.analytic.systems.manoeuvres.line_motion import LineMotion, Phase
from plumbob.analytic.systems.manoeuvres.slow_motion import proper_fraction


def tilt_angle(capsule: Capsule, fraction: float = 1.0) -> float:
    """Returns the tilt of gravity [rad] at which its tangential part is `fraction` of the friction
    limit: tan(alpha) = fraction f. Raises ParameterError.

    Weight acts at the combined centre mu r, which is also the centre of pressure, so the friction
    of every support is in proportion to its N_i. The tilt at the limit is therefore equal in all
    directions and for all places of Q. The heights are zero: the tilt moves no load.
    """
    return math.atan(proper_fraction("fraction", fraction) * capsule.friction)


@dataclass(frozen=True)
class TiltedHold(SingleMotion, LineMotion):
    """A body at rest under gravity tilted along `direction` [rad], by `fraction` of the largest
    tilt, with Q fixed at `slider` relative to C [m]. Friction balances the tangential part of the
    weight, the N_i balance its normal part. Raises ParameterError."""

    capsule: Capsule
    fraction: float
    direction: float = 0.0
    slider: PlanePoint = (0.0, 0.0)
    kind: ClassVar[MotionKind] = "hold"
    sliding_time: ClassVar[float] = 0.0
    start: ClassVar[float] = 0.0
    stroke: ClassVar[float] = 0.0
    phases: ClassVar[tuple[Phase, ...]] = (
        Phase(start=0.0, stroke=0.0, stroke_rate=0.0, pull=0.0),
    )

    def __post_init__(self) -> None:
        tilt_angle(self.capsule, self.fraction)
        finite("direction", self.direction)
        check_loads(self.capsule, self.ends)

    @property
    def ends(self) -> tuple[PlanePoint, PlanePoint]:
        """The slider's place, twice: its stroke has no length."""
        return self.slider, self.slider

    @property
    def angle(self) -> float:
        """Tilt of gravity [rad]."""
        return tilt_angle(self.capsule, self.fraction)

    def normal_forces(self, times: Array) -> Array:
        """Returns the constant normal forces N_i [N] at `times` [s], shape (n, 3)."""
        forces = math.cos(self.angle) * normal_forces(self.capsule, np.array([self.slider]))
        return np.repeat(forces, len(times), axis=0)

    def friction_force(self, times: Array) -> Array:
        """Returns the constant resultant of friction on the body [N] at `times` [s], shape (n,)."""
        return np.full(np.shape(times), -self.capsule.weight * math.sin(self.angle))
