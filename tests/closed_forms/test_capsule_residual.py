"""Residual motions in closed form, against the equations of motion and smoothed friction."""

from __future__ import annotations

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.manoeuvres.residual_motion import spin, translation
from plumbob.analytic.systems.slider_path import fixed
from plumbob.tests.support.plane_motions import pivoting
from plumbob.tests.support.random_capsules import CHECK, capsules
from plumbob.tests.support.random_slides import moved_support
from plumbob.tests.support.smoothed_friction import smoothed_pose

CENTRE, ARM = (0.03, 0.02), 0.2  # a triangle with its circumcentre away from C
ROUND_ABOUT = Capsule(
    *(1.0, 0.3, 0.02),
    (
        (CENTRE[0] + ARM * math.cos(0.3), CENTRE[1] + ARM * math.sin(0.3)),
        (CENTRE[0] + ARM * math.cos(2.2), CENTRE[1] + ARM * math.sin(2.2)),
        (CENTRE[0] + ARM * math.cos(4.4), CENTRE[1] + ARM * math.sin(4.4)),
    ),
    *(0.3, 9.81),
)
NEAR = 1e-10  # accuracy of smoothed friction, extrapolated [m], [rad]
STATE = ("x", "y", "heading", "velocity_x", "velocity_y", "heading_rate")
BALANCED = (CENTRE[0] / ROUND_ABOUT.mass_ratio, CENTRE[1] / ROUND_ABOUT.mass_ratio)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    ("capsule", "slider", "motion"),
    [
        (CHECK, (0.05, 0.1), translation(CHECK, (0.05, 0.1), 0.7, 2.0)),
        (ROUND_ABOUT, BALANCED, spin(ROUND_ABOUT, BALANCED, 5.0)),
        (CHECK, (0.6, 0.0), pivoting(CHECK, (0.6, 0.0), 1, 2.0)),
        (CHECK, (0.5, 0.05), pivoting(CHECK, (0.5, 0.05), 1, -1.5)),
    ],
)
def test_closed_form_is_where_smoothing_tends(capsule, slider, motion):
    time = 0.7 * motion.duration
    start, wanted = np.array([motion.observe(np.array([0.0, time]))[name] for name in STATE]).T
    found = smoothed_pose(capsule, fixed(slider), start, time, delta=1e-6).pose
    np.testing.assert_allclose(found, wanted[:3], rtol=0, atol=NEAR)


@pytest.mark.parametrize(
    "wrong", [replace(CHECK, friction=0.3 * (1 + 1e-4)), moved_support(CHECK, 1e-4)]
)
def test_sensitivity(wrong):
    """f off by 1e-4, or one support moved by 1e-4 of its arm, exceed the accuracy of smoothing."""
    right, off = (pivoting(capsule, (0.6, 0.0), 1, 2.0) for capsule in (CHECK, wrong))
    time = np.array([0.7 * right.duration])
    assert abs(off.observe(time)["heading"] - right.observe(time)["heading"])[0] > 50 * NEAR


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


@pytest.mark.parametrize(
    "motion", [spin(ROUND_ABOUT, BALANCED, 5.0), pivoting(CHECK, (0.6, 0), 1, 2)]
)
def test_velocities_are_those_of_the_places(motion):
    """Central differences over 1e-6 s of a motion of a few rad/s: 1e-10 of rounding."""
    times, small = np.linspace(0.1, 0.9, 9) * motion.duration, 1e-6
    later, sooner, now = (motion.observe(times + shift) for shift in (small, -small, 0.0))
    for place, rate in (("x", "velocity_x"), ("y", "velocity_y"), ("heading", "heading_rate")):
        slope = (later[place] - sooner[place]) / (2 * small)
        np.testing.assert_allclose(slope, now[rate], rtol=0, atol=2e-9)
