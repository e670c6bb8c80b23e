"""A free body's equations of motion, for numbers, arrays or power series.

w_i' = (I_j - I_k)/I_i w_j w_k (Euler),   q' = q w/2,   w in the body's axes, q from body to world
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from plumbob.analytic.numerics.smooth.smooth_motion import SmoothMotion
from plumbob.analytic.numerics.smooth.smooth_system import jacobian
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import ATTITUDE, RATES, quaternion_product


def factors(body: FreeBody) -> tuple[float, float, float]:
    """Returns (I_j - I_k)/I_i for each axis i."""
    x, y, z = body.inertia
    return (y - z) / x, (z - x) / y, (x - y) / z


def acceleration(inertia_factors: Sequence[Any], w: Sequence[Any]) -> list[Any]:
    """Returns the three components of w' from those of w and the `factors` of a body."""
    return [factor * w[i - 2] * w[i - 1] for i, factor in enumerate(inertia_factors)]


def slope(inertia_factors: Sequence[Any], state: Sequence[Any]) -> list[Any]:
    """Returns the derivatives by time of the `state` of a body with these `inertia_factors`: three
    components of the angular velocity in the body's axes, then four of the attitude's
    quaternion."""
    attitude_rate = quaternion_product(state[3:], (0.0, *state[:3]))
    half_rates = (part / 2 for part in attitude_rate)
    return [*acceleration(inertia_factors, state[:3]), *half_rates]


def free_rotation(body: FreeBody) -> SmoothMotion:
    """Returns the exact rotation. Its state is the angular velocity and the attitude."""
    inertia_factors = factors(body)

    def rates(times: Array, states: Array) -> Array:
        return np.array(slope(inertia_factors, [*states]))

    def read(times: Array, states: Array) -> Signals:
        return dict(zip((*RATES, *ATTITUDE), states, strict=True))

    return SmoothMotion(
        start=np.array([*body.angular_velocity, 1.0, 0.0, 0.0, 0.0]),
        slope=rates,
        jacobian=partial(jacobian, rates),
        state=body.rotation.state,
        pace=2 * body.fastest,
        read=read,
    )
