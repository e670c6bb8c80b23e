"""Residual motions in closed form, against the equations of motion and smoothed friction."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.manoeuvres.residual_motion import spin, translation
from plumbob.tests.support.random_capsules import capsules

CENTRE, ARM = (0.03, 0.02), 0.2  # a triangle with its circumcentre away from C


@given(capsules(), st.floats(0.01, 3.0), st.floats(-7.0, 7.0))
def test_stopping_distance(capsule, speed, direction):
    """v0^2/(2 f g) along the direction, wherever Q is, in 40 digits."""
    motion = translation(capsule, (0.1, -0.05), speed, direction)
    times = np.array([motion.duration])
    end, slack = motion.observe(times), motion.uncertainty(times)
    with mpmath.workdps(40):
        way = mpmath.mpf(speed) ** 2 / (2 * mpmath.mpf(capsule.friction) * capsule.gravity)
        wanted = way * mpmath.expj(mpmath.mpf(direction))
    assert abs(end["x"][0] - wanted.real) <= slack["x"][0]
    assert abs(end["y"][0] - wanted.imag) <= slack["y"][0]
    assert (end["velocity_x"][0], end["heading"][0]) == (0.0, 0.0)


def test_spin_about_the_body_centre():
    """Supports at one distance R from C, and not equilateral: f (M + m) g R against J alone."""
    a, b, c = ((ARM * math.cos(a), ARM * math.sin(a)) for a in (0.1, 2.4, 4.0))
    motion = spin(Capsule(1.0, 0.3, 0.02, (a, b, c), 0.3, 9.81), (0.0, 0.0), -6.0)
    braking = 0.3 * 1.3 * 9.81 * ARM / 0.02
    assert motion.coasting.deceleration == pytest.approx(braking, rel=1e-14)
    seen = motion.observe(np.linspace(0.0, 2 * motion.duration, 20))
    assert not seen["x"].any()
    assert not seen["y"].any()
    assert seen["heading"][-1] == pytest.approx(-18.0 / braking, rel=1e-14)
