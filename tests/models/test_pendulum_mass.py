"""The bob's mass, and C and F(t) of the notebook's own equation: what they change, and what not."""

import numpy as np
import pytest

from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene

MASS = 3.7  # [kg]
FORCED = "simple-pendulum/forced-large"  # A 1.5 rad/s^2, xi 0.2/s, L 1 m


def forced(mass, part=1.0):
    """The forced pendulum in the notebook's form: C = xi m, F_0 = A m L, for a bob of `mass`; the
    force is `part` of it."""
    changes = {"mass": mass, "damping": 0.2 * mass, "force": part * 1.5 * mass}
    return find_scene(FORCED, changes)


def test_rates_alone_leave_the_motion_and_scale_the_tension():
    times = np.linspace(0.0, 20.0, 200)
    for name in ("simple-pendulum/rotating-slow", "simple-pendulum/damped-large", FORCED):
        one, other = (
            case_of(find_scene(name, changes)).reference.observe(times)
            for changes in ({}, {"mass": MASS})
        )
        # Sums of products are rounded otherwise where arrays lie otherwise in memory: up to 3e-15.
        np.testing.assert_allclose(one["theta"], other["theta"], rtol=0.0, atol=1e-13)
        np.testing.assert_allclose(
            other["tension"], MASS * one["tension"], rtol=0.0, atol=1e-11
        )


def test_the_notebooks_form_is_the_same_pendulum():
    times = np.linspace(0.0, 20.0, 200)
    plain = case_of(find_scene(FORCED)).reference.observe(times)
    for mass in (0.01, 1.0, MASS, 1e3):
        own = case_of(forced(mass)).reference.observe(times)
        # xi and A are rounded quotients: two ulp, grown by the motion's condition
        np.testing.assert_allclose(own["theta"], plain["theta"], rtol=0, atol=1e-13)
        np.testing.assert_allclose(
            own["tension"], mass * plain["tension"], rtol=0, atol=mass * 1e-12
        )
    # of a rod of 2 m F is over m L, and C over m
    long = find_scene(FORCED, {"length": 2.0})
    given = {"length": 2.0, "mass": MASS, "damping": 0.2 * MASS, "force": 1.5 * MASS * 2.0}
    plain, own = (
        case_of(one).reference.observe(times) for one in (long, find_scene(FORCED, given))
    )
    np.testing.assert_allclose(own["theta"], plain["theta"], rtol=0, atol=1e-13)
    # C alone of a heavier bob damps less
    light, heavy = (
        case_of(find_scene("simple-pendulum/free-large", {"damping": 0.3, "mass": m})).problem
        for m in (1.0, 3.0)
    )
    assert light.damping_rate == pytest.approx(3.0 * heavy.damping_rate, rel=1e-15)
