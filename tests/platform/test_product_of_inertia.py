"""A body without symmetry: a product of inertia tilts the closed form, X and Z do nothing."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.systems.cone_pendulum import ConePendulum, solid_cone
from plumbob.tests.support.high_precision import orbit_of

STEEL = solid_cone(8000.0, 0.3, math.radians(30.0))
TURNING = ConePendulum(STEEL, 0.0, 0.09, 26.0, 9.8, 0.0, 37.0)
FLAT = solid_cone(8000.0, 0.3, math.radians(150.0))  # I_y < I_z
# A body's own moments, a product of inertia, an angle and a speed: all regimes, both signs.
CASES = {
    "rotation": (STEEL, 0.029, 0.0, 37.0),
    "backward": (STEEL, -0.029, 0.4, -37.0),
    "deep well": (STEEL, 0.02, 1.5, 5.0),
    "shallow well": (STEEL, 0.02, -1.47, 2.0),
    "both wells": (STEEL, -0.02, -0.5, 12.0),
    "flat": (FLAT, 0.1, 0.2, 3.0),
    "equal moments": (replace(STEEL, inertia_y=STEEL.inertia_z + 0.85), 0.01, 0.2, 30.0),
}


def posed(name):
    body, product, theta, theta_dot = CASES[name]
    return replace(
        TURNING, body=replace(body, inertia_yz=product), theta=theta, theta_dot=theta_dot
    )


@pytest.mark.parametrize("name", CASES)
def test_against_40_digits(name):
    """The orbit in 40 digits has the product of inertia in its potential and knows no tilt."""
    pendulum = posed(name)
    motion = pendulum.motion
    reference = pendulum.reference
    times = np.array([0.31, 1.7, 20.3]) * motion.period
    seen = reference.observe(times)
    allowed = reference.uncertainty(times)
    guesses = list(zip(seen["theta"], seen["theta_dot"], strict=True))
    period, action, states = orbit_of(pendulum).follow(times.tolist(), guesses)
    assert motion.period == pytest.approx(float(period), rel=4e-15)  # theta + tilt is rounded
    assert motion.action == pytest.approx(float(action), rel=1e-14)
    for i, state in enumerate(states):
        for exact, key in zip(state, ("theta", "theta_dot"), strict=True):
            assert abs(float(seen[key][i] - exact)) <= allowed[key][i]


@pytest.mark.parametrize("name", CASES)
def test_equilibria_and_potential_against_40_digits(name):
    pendulum = posed(name)
    orbit = orbit_of(posed(name))
    critical = sorted(math.remainder(float(x), 2 * math.pi) for x in orbit.critical)
    assert [e.theta for e in pendulum.equilibria] == pytest.approx(critical, abs=1e-15)
    for found in pendulum.equilibria:
        assert found.potential == pytest.approx(float(orbit.potential(found.theta)), rel=1e-13)
        curvature = float(orbit.curvature(found.theta))
        assert (found.kind == "centre") == (curvature > 0.0)
        rate = math.sqrt(abs(curvature) / pendulum.body.inertia_x)
        assert found.rate == pytest.approx(rate, rel=1e-12)


def test_without_a_product_nothing_is_tilted():
    assert TURNING.tilt == 0.0 == TURNING.potential_offset
    assert TURNING.reference is TURNING.motion
    still = replace(posed("rotation"), platform_rate=0.0)
    assert still.tilt == 0.0
