"""The parts of pymunk's capsule: feet and their pins, solver iterations, a driven slider."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.errors.contact_models.sequential_impulse import (
    MOST_ITERATIONS,
    TARGET_RESIDUAL,
    feet_factor,
    iterations_needed,
)
from plumbob.engines.adapters.pymunk.capsule_above import (
    foot_mass,
)
from plumbob.tests.support.random_capsules import CHECK

BESIDE = ((0.2, 0.01), (0.21, -0.01), (0.19, 0.0))  # all on one side of C
AROUND = ((0.2, 0.0), (-0.05, 0.15), (-0.12, -0.1))  # their centroid is not C


@pytest.mark.parametrize("corners", [AROUND, BESIDE])
@pytest.mark.parametrize("fraction", [2.0, 1.0, 0.75, 0.5, 0.05])
def test_feet_leave_the_body_a_quarter_of_its_inertia(corners, fraction):
    body = replace(CHECK, supports=corners, inertia=CHECK.inertia * fraction)
    mass = foot_mass(body)
    places = np.array(corners) @ [1.0, 1j]
    counter = abs(mass * places.sum()) ** 2 / (body.body_mass - 3 * mass)
    feet = mass * (np.abs(places) ** 2).sum() + counter
    assert 0.0 < feet <= 0.75 * body.inertia * (1 + 1e-12)


def test_solver_iterations():
    bodies = [replace(CHECK, slider_mass=m) for m in (1.0, 1e2, 1e4)]
    left = [feet_factor(body, foot_mass(body), np.zeros(2)) for body in bodies]
    # the heavier the slider, the larger the residual of an iteration, its limit
    # 1 - feet/slider
    assert left == sorted(left)
    assert 1 - left[-1] == pytest.approx((1 - left[-2]) / 100, rel=0.05)
    count = iterations_needed(left[0], 1)
    assert left[0] ** count <= TARGET_RESIDUAL < left[0] ** (count - 1)
    assert iterations_needed(left[0], 500) == 500
    assert iterations_needed(left[-1], 1) == iterations_needed(1.0, 1) == MOST_ITERATIONS
    assert iterations_needed(0.0, 1) == 1
