"""The free rigid body as an equation of motion: Euler's equations, and the rate of a quaternion."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.free_body.rotation import ANGULAR_VELOCITY_NAMES, ATTITUDE
from plumbob.engines.adapters.turning import TurningEquation
from plumbob.engines.method import Method
from plumbob.models.largest import DIVERGED_RATIO


def build(problem: Any, method: Method) -> TurningEquation:
    """The equations I w' = (I w) x w and q' = q w/2, both in the body's axes; `problem` is a
    FreeBody."""
    x, y, z = problem.inertia
    first = (y - z) / x
    second = (z - x) / y
    third = (x - y) / z

    def acceleration(time: float, attitude: Array, rate: Array) -> Array:
        """w' [rad/s^2], in the body's axes."""
        u, v, w = rate.tolist()
        return np.array([first * v * w, second * w * u, third * u * v])

    return TurningEquation(
        acceleration,
        position=(1.0, 0.0, 0.0, 0.0),
        rate=tuple(problem.angular_velocity),
        speed=problem.fastest,
        limits=dict.fromkeys(ANGULAR_VELOCITY_NAMES, DIVERGED_RATIO * problem.fastest or 1.0),
        names=ATTITUDE,
        rate_names=ANGULAR_VELOCITY_NAMES,
    )
