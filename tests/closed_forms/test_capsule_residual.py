"""Residual motions in closed form, against the equations of motion and smoothed friction."""

import math

import mpmath
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from plumbob.analytic.systems.manoeuvres.residual_motion import coasting
from plumbob.tests.support.random_capsules import capsules


@given(capsules(), st.floats(0.01, 3.0), st.floats(-7.0, 7.0))
def test_stopping_distance(capsule, speed, direction):
    """v0^2/(2 f g) along the direction, wherever Q is, in 40 digits."""
    motion = coasting(
        capsule, (0.1, -0.05), (speed * math.cos(direction), speed * math.sin(direction))
    )
    times = np.array([motion.sliding_time])
    end = motion.observe(times)
    slack = motion.uncertainty(times)
    with mpmath.workdps(40):
        way = mpmath.mpf(speed) ** 2 / (2 * mpmath.mpf(capsule.friction) * capsule.gravity)
        wanted = way * mpmath.expj(mpmath.mpf(direction))
    assert abs(end["x"][0] - wanted.real) <= slack["x"][0]
    assert abs(end["y"][0] - wanted.imag) <= slack["y"][0]
    assert (end["velocity_x"][0], end["heading"][0]) == (0.0, 0.0)
