"""The references of hard scenes beside 40 digits, or a second method."""

import numpy as np

from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.tests.support.high_precision import orbit_of


def test_a_platform_at_1e4_rad_per_s_against_40_digits():
    pendulum = case_of(find_scene("cone-pendulum/faster-platform")).problem
    reference = pendulum.reference
    times = np.array([1e-4, 1.1e-3, 5e-3])
    seen = reference.observe(times)
    allowed = reference.uncertainty(times)
    guesses = list(zip(seen["theta"], seen["theta_dot"], strict=True))
    _, _, states = orbit_of(pendulum).follow(times.tolist(), guesses)
    for i, state in enumerate(states):
        for exact, key in zip(state, ("theta", "theta_dot"), strict=True):
            assert abs(float(seen[key][i] - exact)) <= allowed[key][i]
    assert (allowed["theta"] / np.abs(seen["theta"]) < 1e-13).all()
