"""The four-bar linkage against an energy integral with 40 digits; its soft loop in MuJoCo."""

from dataclasses import astuple, replace

import numpy as np
import pytest
from mpmath import mp

from plumbob.models.registry import case_of, scene
from plumbob.tests.support import links

TURNING = case_of(scene("four-bar/crank-rocker"))
BARS = TURNING.problem
DRAG_LINK = replace(BARS, crank=0.5, coupler=0.4, ground=0.2, gravity=1.6)


def passed(bars, angle):
    """Time [s] at which a crank that turns forward passes an angle, by the law of cosines."""
    a, b, c, d, *masses, g, begin, rate = map(mp.mpf, astuple(bars))

    def places(t):
        crank = a * mp.expj(t)
        line = d - crank
        square = mp.re(line) ** 2 + mp.im(line) ** 2
        inner = mp.acos((b**2 + square - c**2) / (2 * b * mp.sqrt(square)))
        coupler = b * mp.expj(mp.arg(line) + inner)
        rocker = crank + coupler - d
        middles = crank / 2, crank + coupler / 2, d + rocker / 2
        turns = (mp.arg(link) for link in (crank, coupler, rocker))
        return tuple((mp.re(x), mp.im(x), turn) for x, turn in zip(middles, turns, strict=True))

    return links.passed(places, masses, (a, b, c), g, (begin, angle), rate)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("bars", [BARS, DRAG_LINK], ids=["crank-rocker", "drag-link"])
def test_40_digits(bars):
    error, doubt = links.error_at(0.1, bars, passed)
    assert error < doubt < 2e-13


def test_the_soft_loop_pulls_as_mujoco_s_does():
    for gap in (0.0, 1e-5):  # [rad] of the rocker
        joints, ours = links.loop_accelerations(TURNING, gap)
        # the solver's Hessian costs four digits: a condition of 1/(1 - d)
        np.testing.assert_allclose(np.cumsum(joints), ours, 1e-10, 1e-8)
