"""The slider-crank against an integral of its energy with 40 digits; its soft loop in MuJoCo."""

from dataclasses import astuple, replace

import numpy as np
import pytest
from mpmath import mp

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.models.registry import case_of, scene
from plumbob.tests.support import links

TURNING = case_of(scene("slider-crank/turning"))
CRANK = TURNING.problem


def passed(crank, angle):
    """Time [s] at which a crank that turns forward passes an angle."""
    a, length, *masses, g, begin, rate = map(mp.mpf, astuple(crank))

    def places(t):
        turn = -mp.asin(a * mp.sin(t) / length)
        half = length / 2
        x = a * mp.cos(t) + half * mp.cos(turn)
        y = a * mp.sin(t) + half * mp.sin(turn)
        slider = a * mp.cos(t) + length * mp.cos(turn)
        return (
            (a / 2 * mp.cos(t), a / 2 * mp.sin(t), t),
            (x, y, turn),
            (slider, mp.mpf(0), turn),
        )

    return links.passed(places, masses, (a, length, 0), g, (begin, angle), rate)


@pytest.mark.long
@pytest.mark.parametrize(
    "crank",
    [CRANK, replace(CRANK, rod=0.21, gravity=1.6, slider_mass=3.0)],
    ids=["scene", "short"],
)
def test_40_digits(crank):
    error, doubt = links.error_at(0.25, crank, passed)
    assert error < doubt < 2e-13


def test_the_slider_is_where_the_angle_puts_it():
    times = np.linspace(0.0, 1.0, 11)
    observed = CRANK.motion.observe(times)
    doubt = CRANK.motion.uncertainty(times)
    t = observed["angle"]
    place = CRANK.crank * np.cos(t) + np.sqrt(CRANK.rod**2 - (CRANK.crank * np.sin(t)) ** 2)
    np.testing.assert_allclose(observed["slider"], place, 1e-14)
    slope = np.gradient(place, t)  # of the right size, where it is not next to zero
    assert np.all(doubt["slider"] < 20 * (np.abs(slope) + 0.1) * doubt["angle"] + 1e-15)
    system = CRANK.motion.system
    states = np.stack([t, observed["angle_dot"]])
    root = place - CRANK.crank * np.cos(t)
    sine = CRANK.crank * np.sin(t)
    of_crank = CRANK.crank * np.cos(t) - sine**2 / root
    of_rod = CRANK.rod**2 / root
    rounded = ULP * (np.abs(of_crank) + of_rod + place)  # lengths, and the result
    found = system.doubts(states, np.zeros_like(states))["slider"]
    np.testing.assert_allclose(found, rounded, 1e-12)


def test_the_soft_loop_pulls_as_mujoco_s_does():
    for gap in (0.0, 1e-5):  # [m]
        (crank, rod, slider), ours = links.loop_accelerations(TURNING, gap)
        # the solver's Hessian costs four digits: a condition of 1/(1 - d)
        np.testing.assert_allclose([crank, crank + rod, slider], ours, 1e-10)
