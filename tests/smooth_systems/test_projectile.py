"""The projectile against its parabola, and what steps add to it exactly."""

import numpy as np
from mpmath import mp

from plumbob.models.registry import case_of, scene

CASE = case_of(scene("projectile/thrown"))
TIMES = np.linspace(0.0, 1.5, 31)


def thrown(body, time):
    """A parabola, and the angle of a body that nothing turns."""
    speed, elevation, spin, g = map(
        mp.mpf, (body.speed, body.elevation, body.spin, body.gravity)
    )
    return {
        "x": speed * mp.cos(elevation) * time,
        "z": speed * mp.sin(elevation) * time - g * time**2 / 2,
        "angle": spin * time,
    }


def test_40_digits():
    observed, doubt = (f(TIMES) for f in (CASE.reference.observe, CASE.reference.uncertainty))
    body = CASE.problem
    with mp.workdps(40):
        for k, time in enumerate(map(mp.mpf, TIMES)):
            for name, value in thrown(body, time).items():
                assert abs(value - mp.mpf(float(observed[name][k]))) <= doubt[name][k] < 1e-13
