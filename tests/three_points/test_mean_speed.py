"""The mean speed of repeated manoeuvres, against the manoeuvres themselves and a grid."""

import math
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from mpmath import mp

from plumbob.analytic.systems.capsule import longest_stroke, normal_forces
from plumbob.analytic.systems.manoeuvres.mean_speed import (
    fastest_manoeuvre,
    fastest_speed,
    mean_speed,
)
from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.tests.support.random_capsules import CHECK, LIMIT

STROKE = 0.5  # [m]


def test_the_bound_in_rational_arithmetic():
    """V^2 of the bound is mu f g L/(2 sqrt 2 + 4)^2 = mu f g L (3 - 2 sqrt 2)/8."""
    m, f, g, stroke = (Fraction(v) for v in (0.3, 0.3, 9.81, STROKE))
    part = m / (1 + m) * f * g * stroke
    root = Fraction(math.isqrt(2 * 10**80), 10**40)
    squared = part * (3 - 2 * root) / 8
    assert fastest_speed(CHECK, STROKE) ** 2 == pytest.approx(float(squared), rel=1e-14)


@pytest.mark.parametrize(("push", "brake", "fraction"), [(3.0, 0.8, 1.0), (1.1, 0.3, 0.2)])
def test_a_manoeuvre_and_a_return_in_40_digits(push, brake, fraction):
    """The way over the time: t_1 from the stroke (Chernousko 2020, eq. 18), t_2 (17), the way of
    the body (22), and a return that gains and loses speed at a fraction of f g/mu."""
    with mp.workdps(40):
        part, pull = mp.mpf(CHECK.slider_mass), mp.mpf(CHECK.friction) * mp.mpf(CHECK.gravity)
        mu = part / (part + mp.mpf(CHECK.body_mass))
        w1, w2 = mp.mpf(push * LIMIT), mp.mpf(brake * LIMIT)
        t1 = mp.sqrt(2 * w2 * mp.mpf(STROKE) / (w1 * (w1 + w2)))
        there = t1 * (w1 + w2) / w2
        back = 2 * mp.sqrt(mp.mpf(STROKE) / (mp.mpf(fraction) * pull / mu))
        moved = mu * (w1 + w2) * (mu * w1 - pull) * t1**2 / (2 * (mu * w2 + pull))
        speed = float(moved / (there + back))
    found = mean_speed(CHECK, push * LIMIT, brake * LIMIT, STROKE, fraction)
    assert found == pytest.approx(speed, rel=1e-14)


def test_no_point_of_a_grid_is_faster():
    most = 20 * LIMIT
    best = mean_speed(CHECK, most, LIMIT, STROKE)
    grid = product(
        np.geomspace(1.01 * LIMIT, most, 40),
        np.geomspace(0.01 * LIMIT, LIMIT, 40),
        np.linspace(0.05, STROKE, 10),
        np.linspace(0.1, 1.0, 10),
    )
    assert max(mean_speed(CHECK, *map(float, point)) for point in grid) == pytest.approx(
        best, rel=1e-12
    )
    one = RepeatedLine(fastest_manoeuvre(CHECK, most, STROKE), 1)
    assert one.mean_speed == pytest.approx(best, rel=1e-13)
    assert one.manoeuvre.stroke == pytest.approx(STROKE, rel=1e-13)
    slower = RepeatedLine(replace(one.manoeuvre, w2=0.999 * LIMIT), 1)
    assert slower.mean_speed < best * (1 - 1e-4)
    assert best < fastest_speed(CHECK, STROKE) < 1.1 * best


def test_the_longest_stroke_ends_where_a_support_is_unloaded():
    unit = np.array([math.cos(1.0), math.sin(1.0)])
    ends = normal_forces(CHECK, np.outer(longest_stroke(CHECK, 1.0), unit)).min(axis=1)
    np.testing.assert_allclose(ends, 0.0, atol=1e-14 * CHECK.weight)
