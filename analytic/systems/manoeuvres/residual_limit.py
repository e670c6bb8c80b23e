"""Slow residual motion: how far a slowly moving body coasts, to leading order in its speed."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.systems.capsule import Capsule, Point
from plumbob.analytic.systems.slider_path import fixed
from plumbob.analytic.systems.three_points.friction import Start, three_point_motion
from plumbob.analytic.systems.three_points.smooth_segment import state_at

SLOW = 1e-6  # its square is about the turn of the coasting body [rad], which the limit leaves out


def residual_limit(
    capsule: Capsule, slider: Point, velocity: complex, omega: float
) -> tuple[complex, float, float]:
    """Way of the combined centre and turn of the body over lambda^2, and time to rest over lambda,
    when it coasts from lambda times a velocity and an angular velocity, lambda -> 0.

    `slider` r [m] in body axes; `velocity` of the combined centre, complex, body axes; `omega`
    likewise. A body that hardly turns while it stops sees a friction that depends on the direction
    of (velocity, omega) alone: the way is homogeneous of degree two.
    """
    arm = capsule.mass_ratio * complex(*slider)
    lever = float(max(abs(complex(*point) - arm) for point in capsule.supports))
    speed = abs(velocity) + lever * abs(omega)
    if speed == 0.0:
        return 0j, 0.0, 0.0
    # A stop from speed v turns the body by about v^2/(f g lever).
    scale = float(np.sqrt(SLOW**2 * capsule.friction * capsule.gravity * lever)) / speed
    own = scale * (velocity - 1j * omega * arm)
    # With the combined centre at the ground's origin its small way keeps all its digits.
    start = Start((-arm.real, -arm.imag), 0.0, (own.real, own.imag), scale * omega)
    motion = three_point_motion(capsule, fixed(slider), start)
    last = [segment for segment in motion.segments if segment.coefficients is not None][-1]
    assert last.coefficients is not None
    end = state_at(last.coefficients, last.last)
    way = end.place - motion.segments[0].first.place
    return way / scale**2, end.heading / scale**2, motion.rest_time / scale
