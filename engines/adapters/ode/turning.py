"""Equations of motion of a body's attitude: x' = x v/2 as quaternions, with the angular velocity v
in the body's axes. Euler and leapfrog turn the body by the angular velocity of the step, exactly;
RK4 takes the quaternion as four numbers like any others.
"""

from __future__ import annotations

import math

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.equation import Equation


class TurningEquation(Equation):
    """An `Equation` whose position is a quaternion, shape (4,), and whose rate is an angular
    velocity, shape (3,)."""

    def slope(self, position: Array, rate: Array) -> Array:
        """Rate of the quaternion [1/s]."""
        (a, b, c, d) = position.tolist()
        (x, y, z) = (0.5 * rate).tolist()
        return np.array(
            [
                -b * x - c * y - d * z,
                a * x + c * z - d * y,
                a * y - b * z + d * x,
                a * z + b * y - c * x,
            ]
        )

    def drifted(self, position: Array, rate: Array, h: float) -> Array:
        """The attitude after the time `h` [s] at a constant rate."""
        speed = math.sqrt(rate @ rate)
        half = 0.5 * h * speed
        ratio = 2.0 * math.sin(half) / speed if speed else 0.0
        return math.cos(half) * position + ratio * self.slope(position, rate)
