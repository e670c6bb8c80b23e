"""The actuator's force: against rational arithmetic, the slider's path in space, and engines."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given

from plumbob.analytic.systems.manoeuvres.driving_force import force_demand
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import turn_of
from plumbob.analytic.systems.three_points.forces import plane_demand
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.tests.support.plane_motions import loadings
from plumbob.tests.support.random_capsules import CHECK, lines


@given(lines())
def test_on_a_line_against_rational_arithmetic(line):
    """F = m (a_C + w) of eq. 9 on each of the three intervals, and its mean square."""
    c = line.capsule
    closed = line.closed
    m = Fraction(c.slider_mass)
    mu = Fraction(c.slider_mass) / (Fraction(c.body_mass) + Fraction(c.slider_mass))
    limit = Fraction(c.friction) * Fraction(c.gravity)
    w1, w2, t1 = (Fraction(value) for value in (line.w1, line.w2, line.t1))
    stop = mu * (w1 + w2) * t1 / (mu * w2 + limit)
    edges = [Fraction(0), t1, stop, (w1 + w2) * t1 / w2]
    exact = [m * (w1 - mu * w1 + limit), m * (-w2 + mu * w2 + limit), -m * w2]
    ends = [line.t1, closed.t_star, closed.t2]
    middles = 0.5 * (np.array([0.0, line.t1, closed.t_star]) + np.array(ends))
    found, doubt = (
        getattr(line, name)(middles)["driving_force"] for name in ("observe", "uncertainty")
    )
    for value, force, off, first, last in zip(
        found, exact, doubt, edges[:-1], edges[1:], strict=True
    ):
        if last - first > 1e-12 * last:  # else there is no middle
            assert abs(Fraction(value) - force) <= off
    square = sum(f * f * (b - a) for f, a, b in zip(exact, edges[:-1], edges[1:], strict=True))
    wanted = force_demand(line, line.t2)
    assert wanted.rms == pytest.approx(math.sqrt(square / edges[-1]), rel=1e-12)
    assert wanted.peak == pytest.approx(float(max(map(abs, exact))), rel=1e-12)
    assert wanted.power == pytest.approx(float(abs(exact[0]) * w1 * t1), rel=1e-12)


def turning():
    return three_point_motion(CHECK, turn_of(CHECK, 0.12, 0.3).path)


def in_space(motion, times):
    """Place of the slider on the ground, complex [m]."""
    pose = motion.at(times)
    inside = motion.path.kinematics(times)[0] @ [1.0, 1j]
    return np.asarray(pose.position @ [1.0, 1j] + inside * np.exp(1j * pose.heading))


def test_in_the_plane_it_is_what_accelerates_the_slider():
    """m times the second difference of the slider's place in space, extrapolated once."""
    motion = turning()
    tau = 0.5 * motion.path.duration
    times = np.array([0.3, 0.7, 1.2, 1.9]) * tau
    h = 1e-3 * tau
    seen = []
    for step in (h, 2 * h):
        before, here, after = (in_space(motion, times + shift) for shift in (-step, 0.0, step))
        seen.append((after - 2 * here + before) / step**2)
    pushed = CHECK.slider_mass * (4 * seen[0] - seen[1]) / 3
    heading = motion.at(times).heading
    found = np.concatenate([load.actuator for load in loadings(motion, times)])
    found = found * np.exp(1j * heading)
    np.testing.assert_allclose(found, pushed, rtol=0, atol=1e-7 * np.abs(pushed).max())
    wanted = plane_demand(motion)
    assert wanted.rms < wanted.peak
    assert np.abs(pushed).max() < wanted.peak < 2 * np.abs(pushed).max()
