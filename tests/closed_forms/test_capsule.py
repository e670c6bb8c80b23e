"""The capsule: normal forces, valid paths, and why any line through C is possible."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from plumbob.analytic.systems.capsule import (
    Arc,
    normal_force_uncertainty,
    normal_forces,
    source_assumption,
    validity,
)
from plumbob.tests.support.random_capsules import CHECK, LINE, capsules

places = st.floats(-3.0, 3.0)
angles = st.floats(-7.0, 7.0)


@given(capsules(), places, places)
def test_normal_forces_balance_both_weights(capsule, x, y):
    """Sum of forces, and of moments about C: weights of M at C and m at Q."""
    forces = normal_forces(capsule, np.array([[x, y], [0.0, 0.0]]))
    arms = np.asarray(capsule.supports)
    slack = 3 * normal_force_uncertainty(capsule, math.hypot(x, y))
    np.testing.assert_allclose(forces.sum(axis=1), capsule.weight, rtol=0, atol=slack)
    carried = capsule.slider_mass * capsule.gravity * np.array([[x, y], [0.0, 0.0]])
    reach = max(1.0, np.abs(arms).max())
    np.testing.assert_allclose(forces @ arms, carried, rtol=0, atol=slack * reach)


@given(capsules(), angles, places, places)
def test_friction_balances_about_every_line_through_c(capsule, heading, along, across):
    unit = np.array([math.cos(heading), math.sin(heading)])
    spots = np.array([along * unit, along * unit + across * np.array([-unit[1], unit[0]])])
    pressed = normal_forces(capsule, spots) @ np.asarray(capsule.supports)
    moments = -capsule.friction * pressed @ [unit[1], -unit[0]]
    friction_limit = capsule.friction * capsule.slider_mass * capsule.gravity
    slack = 3 * normal_force_uncertainty(capsule, math.hypot(along, across))
    reach = 2.0 * capsule.friction  # the longest arm [m], and f
    np.testing.assert_allclose(
        moments, [0.0, friction_limit * across], rtol=0, atol=slack * reach
    )


def test_validity_names_the_support_that_lifts():
    assert validity(CHECK, LINE.ends) == ()
    # The turn of physics takes Q out of the triangle, and every support stays loaded.
    around = (Arc(0.12, 0.0, 7.0),)
    assert validity(CHECK, around) == ()
    assumed = source_assumption(CHECK, around)
    assert (assumed.com_inside, assumed.slider_inside) == (True, False)
