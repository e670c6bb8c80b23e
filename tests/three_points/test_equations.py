"""The equations of sliding, whose derivatives are those of small changes, and its segments."""

import numpy as np

from plumbob.analytic.systems.slider_path import arc_stroke
from plumbob.analytic.systems.three_points.equations import (
    configuration,
    mechanics,
    sliding_rates,
)
from plumbob.tests.support.random_capsules import CHECK

CHANGE = 1e-6  # central differences: 1e-12 of the third derivative, and 1e-10 of rounding


def test_derivatives_by_the_velocities_are_those_of_small_changes():
    body = mechanics(CHECK)
    at = configuration(body, arc_stroke(0.12, 0.3, 40.0, 0.1).pieces[0], np.array([0.02, 0.07]))
    state = np.array([[0.3, -0.2, 2.5], [-0.5, 0.1, -4.0]])
    _, derivative = sliding_rates(body, at, state, None)
    for k in range(3):
        more, less = (
            sliding_rates(body, at, state + sign * CHANGE * np.eye(3)[k], None)[0]
            for sign in (1.0, -1.0)
        )
        slope = (more - less) / (2.0 * CHANGE)
        np.testing.assert_allclose(derivative[:, :, k], slope, rtol=1e-7, atol=1e-7)
