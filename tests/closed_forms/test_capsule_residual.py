"""Residual motions in closed form, against the equations of motion and smoothed friction."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from plumbob.analytic.errors.sliding_motion.sliding_errors import coasting_errors
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.capsule import Capsule, Point, normal_forces
from plumbob.analytic.systems.manoeuvres.residual_motion import (
    ResidualMotion,
    pivoting,
    spin,
    translation,
)
from plumbob.tests.support.random_capsules import CHECK, capsules

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
STATE = ("heading", "velocity_x", "velocity_y", "heading_rate")
BALANCED: Point = (CENTRE[0] / ROUND_ABOUT.mass_ratio, CENTRE[1] / ROUND_ABOUT.mass_ratio)


def smoothed(capsule: Capsule, slider: Point, rates: Array, time: float, delta: float) -> Array:
    """Heading and velocities of C, and the heading's, at `time`, with |v| replaced by
    sqrt(v^2 + delta^2); eqs. 2-4, Q fixed."""
    corners, place = np.asarray(capsule.supports), np.asarray(slider)
    limits = capsule.friction * normal_forces(capsule, place[None])[0]
    m, both = capsule.slider_mass, capsule.slider_mass + capsule.body_mass

    def flow(_: float, state: Array) -> Array:
        heading, velocity, omega = state[0], state[1:3], state[3]
        cos, sin = math.cos(heading), math.sin(heading)
        turn = np.array([[cos, sin], [-sin, cos]])
        arms, r = corners @ turn, place @ turn
        sliding = velocity + omega * np.stack([-arms[:, 1], arms[:, 0]], axis=1)
        speeds = np.sqrt((sliding**2).sum(axis=1) + delta**2)
        forces = -(limits / speeds)[:, None] * sliding
        moment = float((arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0]).sum())
        inertia = np.array(
            [
                [both, 0.0, -m * r[1]],
                [0.0, both, m * r[0]],
                [-m * r[1], m * r[0], capsule.inertia + m * r @ r],
            ]
        )
        push = np.array([*(forces.sum(axis=0) + m * omega**2 * r), moment])
        return np.concatenate([state[3:], np.linalg.solve(inertia, push)])

    start = np.concatenate([[0.0], rates])
    found = solve_ivp(flow, (0.0, time), start, method="Radau", rtol=1e-10, atol=1e-13)
    return np.asarray(found.y[:, -1])


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
def test_closed_form_is_where_smoothing_tends(
    capsule: Capsule, slider: Point, motion: ResidualMotion
) -> None:
    """The difference vanishes with delta: linearly for a support at rest, faster without one."""
    time = 0.7 * motion.duration
    seen = motion.observe(np.array([0.0, time]))
    start, wanted = np.array([seen[name] for name in STATE]).T
    errors = [
        np.abs(smoothed(capsule, slider, start[1:], time, delta) - wanted).max()
        for delta in (1e-3, 1e-5)
    ]
    # Sliding at some 0.3 m/s is disturbed by delta over that; 1e-11 is the solver's own.
    assert errors[0] <= 1e-3
    assert errors[1] <= errors[0] / 90 + 1e-11


@pytest.mark.long
def test_sensitivity() -> None:
    """The same check sees f off by 1e-4, and one support moved by 1e-4 of its arm."""
    motion = pivoting(CHECK, (0.6, 0.0), 1, 2.0)
    time = 0.7 * motion.duration
    seen = motion.observe(np.array([0.0, time]))
    start, end = np.array([seen[name] for name in STATE]).T
    heading = smoothed(CHECK, (0.6, 0.0), start[1:], time, 1e-6)[0]
    for wrong in (
        replace(CHECK, friction=0.3 * (1 + 1e-4)),
        replace(CHECK, supports=((0.2 * (1 + 1e-4), 0.0), *CHECK.supports[1:])),
    ):
        off = pivoting(wrong, (0.6, 0.0), 1, 2.0).observe(np.array([time]))["heading"][0]
        assert abs(off - heading) > 50 * abs(end[0] - heading)


@given(capsules(), st.floats(0.01, 3.0), st.floats(-7.0, 7.0))
def test_stopping_distance(capsule: Capsule, speed: float, direction: float) -> None:
    """v0^2/(2 f g) along the direction, wherever Q is, in 40 digits."""
    motion = translation(capsule, (0.1, -0.05), speed, direction)
    end = motion.observe(np.array([motion.duration]))
    with mpmath.workdps(40):
        friction_limit = mpmath.mpf(capsule.friction) * mpmath.mpf(capsule.gravity)
        way = mpmath.mpf(speed) * abs(mpmath.mpf(speed)) / (2 * friction_limit)
        wanted = way * mpmath.cos(mpmath.mpf(direction)), way * mpmath.sin(mpmath.mpf(direction))
    slack = motion.uncertainty(np.array([motion.duration]))
    assert abs(end["x"][0] - wanted[0]) <= slack["x"][0]
    assert abs(end["y"][0] - wanted[1]) <= slack["y"][0]
    assert (end["velocity_x"][0], end["heading"][0]) == (0.0, 0.0)


def test_spin_about_the_body_centre() -> None:
    """Supports at one distance R from C, and not equilateral: f (M + m) g R against J alone."""
    corners = [(ARM * math.cos(a), ARM * math.sin(a)) for a in (0.1, 2.4, 4.0)]
    capsule = Capsule(1.0, 0.3, 0.02, (corners[0], corners[1], corners[2]), 0.3, 9.81)
    motion = spin(capsule, (0.0, 0.0), -6.0)
    assert motion.coasting.deceleration == pytest.approx(0.3 * 1.3 * 9.81 * ARM / 0.02, rel=1e-14)
    seen = motion.observe(np.linspace(0.0, 2 * motion.duration, 20))
    assert np.abs(seen["x"]).max() == np.abs(seen["y"]).max() == 0.0
    assert seen["heading"][-1] == pytest.approx(-18.0 / motion.coasting.deceleration, rel=1e-14)
    step = motion.duration / 100  # It stops on the grid: the lead is the only error.
    error = coasting_errors(motion, Scheme(EULER), step, np.array([motion.duration]))
    assert error["heading"][0] / step == pytest.approx(3.0, rel=1e-13)


@pytest.mark.parametrize(
    "motion", [spin(ROUND_ABOUT, BALANCED, 5.0), pivoting(CHECK, (0.6, 0), 1, 2)]
)
def test_velocities_are_those_of_the_places(motion: ResidualMotion) -> None:
    """Central differences over 1e-6 s of a motion of a few rad/s: 1e-10 of rounding."""
    times, small = np.linspace(0.1, 0.9, 9) * motion.duration, 1e-6
    later, sooner, now = (motion.observe(times + shift) for shift in (small, -small, 0.0))
    for place, rate in (("x", "velocity_x"), ("y", "velocity_y"), ("heading", "heading_rate")):
        slope = (later[place] - sooner[place]) / (2 * small)
        np.testing.assert_allclose(slope, now[rate], rtol=0, atol=2e-9)


@pytest.mark.parametrize(
    ("build", "name"),
    [
        (lambda: spin(CHECK, (0.0, 0.0), 1.0), "supports"),
        (lambda: spin(ROUND_ABOUT, (0.0, 0.0), 1.0), "supports"),
        (lambda: pivoting(CHECK, (0.6, 0.0), 1, 8.0), "rate"),
        (lambda: pivoting(replace(CHECK, inertia=1.0), (0.0, 0.0), 1, 0.0), "rate"),
        (lambda: pivoting(CHECK, (0.6, 0.0), 0, 1.0), "support"),
        (lambda: translation(CHECK, (2.0, 0.0), 1.0, 0.0), "normal_force_2"),
        (lambda: translation(CHECK, (0.0, 0.0), math.nan, 0.0), "speed"),
    ],
)
def test_a_motion_without_a_formula_is_refused(
    build: Callable[[], ResidualMotion], name: str
) -> None:
    with pytest.raises(ParameterError) as caught:
        build()
    assert caught.value.name == name
    assert "\n" not in str(caught.value)
