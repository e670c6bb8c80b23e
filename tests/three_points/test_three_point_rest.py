"""The set of wrenches that static friction balances, and how a body starts to move outside it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plumbob.analytic.systems.three_points.implicit_friction import load_factor

RATES = st.floats(-3.0, 3.0)


@st.composite
def supports(draw):
    """Limits f N_i [N] and arms from the centre of pressure [m]: sum N_i arm_i = 0."""
    gaps = [draw(st.floats(0.4, 1.0)) for _ in range(3)]
    angles = 2 * math.pi * np.cumsum(gaps) / sum(gaps)
    arms = np.array([draw(st.floats(0.05, 0.5)) for _ in range(3)]) * np.exp(1j * angles)
    fractions = np.array([draw(st.floats(0.02, 1.0)) for _ in range(3)])
    fractions /= fractions.sum()
    return 3.0 * fractions, arms - fractions @ arms


def rate(velocity, arms):
    """Velocities of the supports, of a body with this (x, y, angle) rate."""
    return np.asarray(complex(velocity[0], velocity[1]) + 1j * velocity[2] * arms)


def wrench(forces, arms):
    """Sum and moment of `forces` at `arms`."""
    return complex(forces.sum()), float((arms.conjugate() * forces).imag.sum())


@given(supports(), st.tuples(RATES, RATES, RATES), st.floats(0.1, 5.0))
def test_a_full_slip_is_the_edge_of_the_set(held, slip, size):
    """Forces f N_i along v_i of any rigid velocity are extreme: load factor 1, times any factor."""
    limits, arms = held
    velocities = rate(slip, arms)
    if np.abs(velocities).min() < 1e-3:
        return
    force, torque = wrench(size * limits * velocities / np.abs(velocities), arms)
    factor, worst = load_factor(limits, arms, force, torque)
    assert factor == pytest.approx(size, rel=1e-13)
    # The direction is the argument of a minimum: accurate to the root of the accuracy of its value.
    along = np.array(slip) / np.linalg.norm(slip)
    way = np.array([worst[0].real, worst[0].imag, worst[1]])
    assert np.abs(way / np.linalg.norm(way) - along).max() <= 1e-5
