"""Equations of motion with quaternions as attitudes: q' = q w/2, with the angular velocity w in the
body's axes. Euler and leapfrog turn a body exactly by the angular velocity of the step. RK4 treats
the four numbers of a quaternion like any other coordinates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.equation import Equation


@dataclass(frozen=True)
class TurningEquation(Equation):
    """An `Equation` some of whose coordinates are quaternions, shape (4,), with angular velocities,
    shape (3,), as their rates."""

    attitudes: tuple[tuple[int, int], ...] = ((0, 0),)
    """For each quaternion, the number of its first coordinate and of the first rate of its angular
    velocity. Every other coordinate has one rate."""

    def slope(self, position: Array, rate: Array) -> Array:
        """The derivatives of the coordinates by time: the rates, except for quaternions, whose
        derivatives follow from their angular velocities."""
        parts = list[Array]()
        first = 0
        for place, turn in self.attitudes:
            parts.append(rate[first:turn])
            parts.append(_turning(position[place : place + 4], rate[turn : turn + 3]))
            first = turn + 3
        return np.concatenate([*parts, rate[first:]])

    def drifted(self, position: Array, rate: Array, h: float) -> Array:
        """The coordinates after the time `h` [s] at a constant rate."""
        after = position + h * self.slope(position, rate)
        for place, turn in self.attitudes:
            attitude = position[place : place + 4]
            spin = rate[turn : turn + 3]
            speed = math.sqrt(spin @ spin)
            half = 0.5 * h * speed
            ratio = 2.0 * math.sin(half) / speed if speed else 0.0
            turned = math.cos(half) * attitude + ratio * _turning(attitude, spin)
            after[place : place + 4] = turned
        return after


def _turning(attitude: Array, spin: Array) -> Array:
    """The derivative of a quaternion [1/s] at an angular velocity [rad/s] in the body's axes."""
    (a, b, c, d) = attitude.tolist()
    (x, y, z) = (0.5 * spin).tolist()
    return np.array(
        [
            -b * x - c * y - d * z,
            a * x + c * z - d * y,
            a * y - b * z + d * x,
            a * z + b * y - c * x,
        ]
    )
