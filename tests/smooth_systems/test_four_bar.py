"""The four-bar linkage against an energy integral with 40 digits; its soft loop in MuJoCo."""

import math
from dataclasses import astuple, replace

import numpy as np
import pytest
from mpmath import mp

from plumbob.analytic.parameters import ParameterError
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


def test_links_keep_their_lengths():
    for name in ("four-bar/crank-rocker", "four-bar/near-change-point"):
        case = case_of(scene(name))
        seen = case.reference.observe(np.linspace(0.0, case.scene.duration, 101))
        crank = case.problem.crank * np.exp(1j * seen["angle"])
        half = seen["coupler_x"] + 1j * seen["coupler_y"] - crank
        lengths = 2 * np.abs(half), np.abs(crank + 2 * half - case.problem.ground)
        np.testing.assert_allclose(lengths[0], case.problem.coupler, 1e-14)
        np.testing.assert_allclose(lengths[1], case.problem.rocker, 1e-13)


def test_the_transmission_angle_is_the_smallest_between_coupler_and_rocker():
    turned = np.linspace(0.0, 2 * math.pi, 721)
    crank = BARS.crank * np.exp(1j * turned)
    cosine = BARS.coupler**2 + BARS.rocker**2 - np.abs(BARS.ground - crank) ** 2
    least = np.arccos(np.abs(cosine) / (2 * BARS.coupler * BARS.rocker)).min()
    assert BARS.transmission_angle == pytest.approx(least, rel=1e-14)


def test_the_soft_loop_pulls_as_mujoco_s_does():
    for gap in (0.0, 1e-5):  # [rad] of the rocker
        joints, ours = links.loop_accelerations(TURNING, gap)
        # the solver's Hessian costs four digits: a condition of 1/(1 - d)
        np.testing.assert_allclose(np.cumsum(joints), ours, 1e-10, 1e-8)


def test_a_change_point_is_refused_and_so_is_a_crank_that_stops():
    for rocker, coupler in ((0.2, 0.5), (0.2, 0.5 + 1e-16), (0.3, 0.4)):
        with pytest.raises(ParameterError, match="motion beyond the change point is not unique"):
            replace(BARS, rocker=rocker, coupler=coupler)
    with pytest.raises(ParameterError, match=r"coupler \+ rocker$"):
        replace(BARS, crank=0.45)
