"""How uniform rotation is: the quadrature against the closed form and 40 digits, and the proof that
the range of speeds never shrinks."""

import math
from dataclasses import replace

import gmpy2
import numpy as np
import pytest

from plumbob.analytic.systems.cone_pendulum import ConePendulum, cone
from plumbob.analytic.systems.pendulums import uniformity
from plumbob.reports.analyses.cone_pendulum import source_text
from plumbob.reports.analyses.cone_pendulum.hamiltonian import ROTATING, closed_forms
from plumbob.tests.support.high_precision import orbit_of

STEEL = cone(8000.0, 0.3, math.radians(30.0))
TURNING = ConePendulum(STEEL, 0.0, 0.09, 26.0, 9.8, 0.0, 37.0)
# pivot_y, platform rate, theta_dot: spread, deviation, near; integrated independently
KNOWN = {
    (0.0, 0.0, 13.0): (0.775117, 0.498282, 0.114),
    (0.0, 8.0, 13.0): (0.797289, 0.472542, 0.319),
    (0.09, 0.0, 37.0): (0.0604282, 0.0220349, 0.723),
    (0.09, 10.0, 37.0): (0.100832, 0.0316636, 0.815),
    (0.09, 26.0, 37.0): (0.431099, 0.124350, 0.484),
}


def posed(pivot_y, rate, speed):
    return replace(TURNING, pivot_y=pivot_y, platform_rate=rate, theta_dot=speed)


@pytest.mark.parametrize("point", KNOWN)
def test_deviation_against_40_digits(point):
    """The mean speed is 2 pi/T and its mean square 2 pi I/(inertia T), in 40 digits."""
    pendulum = posed(*point)
    period, action, _ = orbit_of(pendulum).follow()
    turn = 2 * gmpy2.const_pi()
    mean = turn / period
    square = turn * action / (STEEL.inertia_x * period)
    deviation = gmpy2.sqrt(square - mean * mean) / mean
    found = uniformity.uniformity_of_motion(pendulum.motion).deviation
    # two numbers of size 1 that are each exact to some 1e-15 are subtracted
    assert float(found) == pytest.approx(float(deviation), abs=4e-15 / float(deviation))


@pytest.mark.parametrize("axis", [0, 1])
def test_maps_have_the_closed_form_s_period(axis):
    """By S, where the inertia about the pivot follows it, and by Y; and which cells rotate."""
    name, values = source_text.AXES[axis]
    fig_3 = closed_forms(ROTATING).problem
    drawn = source_text.period_map(fig_3, name, values)
    for row, column in ((3, 5), (20, 8), (30, 30), (12, 40), (35, 2)):
        value = float(values[row])
        body = fig_3.body
        if name == "S":
            more = body.mass * (value**2 - body.com_distance**2)
            inertia = {"inertia_x": body.inertia_x + more, "inertia_y": body.inertia_y + more}
            there = replace(fig_3, body=replace(body, com_distance=value, **inertia))
        else:
            there = replace(fig_3, pivot_y=value)
        motion = replace(there, platform_rate=float(source_text.RATES[column])).motion
        power = drawn.powers[row, column]
        assert np.isfinite(power) == (motion.regime == "rotation")
        if np.isfinite(power):
            assert fig_3.motion.period * 10**power == pytest.approx(motion.period, rel=1e-10)
    assert 0.3 < drawn.rotating < 0.9
