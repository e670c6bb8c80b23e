"""What holds for every pendulum, whatever its parameters: symmetries, invariants, derivatives."""

import math
from dataclasses import replace

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import double, quad
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion

signs = st.sampled_from([-1.0, 1.0])
sizes = st.one_of(st.floats(1e-2, 100.0), st.floats(1e-10, 1e-2))
signed = st.builds(lambda sign, size: sign * size, signs, sizes)
forces = st.one_of(st.just(0.0), signed)
potentials = st.builds(TrigonometricPotential, forces, forces, forces)


def motions():
    """Pendulums drawn at random, of all regimes, with potentials from zero to 100 J."""
    inertias = st.floats(0.01, 100.0)
    angles = st.floats(-10.0, 10.0)
    return st.builds(PendulumMotion, potentials, inertias, angles, signed)


def energies(motion, theta, theta_dot):
    kinetic = motion.inertia * theta_dot**2 / 2
    value = kinetic + double(motion.closed_form.potential.value(quad(theta)))
    return value


def scale(motion):
    """Scale of the rounding of energies: the potential and the kinetic energy [J]."""
    return float(motion.closed_form.potential.scale) + motion.inertia * motion.theta_dot**2


def times_of(motion):
    """Some periods, either side of the start."""
    span = motion.period if math.isfinite(motion.period) else 1.0
    return np.linspace(-2.2, 3.1, 301) * span


@given(motions())
def test_energy_is_conserved(motion):
    theta, theta_dot = motion.state(times_of(motion))
    drift = energies(motion, theta, theta_dot) - double(motion.energy)
    assert np.abs(drift).max() <= 1e-12 * scale(motion)


@given(motions())
def test_time_reversal(motion):
    times = times_of(motion)
    theta, theta_dot = motion.closed_form.state(times)
    back, rate = replace(motion, theta_dot=-motion.theta_dot).closed_form.state(-times)
    close(motion, times, theta - back, theta_dot + rate)


def close(motion, times, angle, rate):
    """Two solutions of one problem differ by rounding only."""
    allowed = motion.uncertainty(times)
    assert (np.abs(angle) <= 5 * allowed["theta"]).all()
    assert (np.abs(rate) <= 5 * allowed["theta_dot"]).all()


@given(motions())
def test_the_table_is_the_closed_form(motion):
    assume(motion.table)
    times = times_of(motion)
    theta, rate = motion.closed_form.state(times)
    angle, slope = motion.table.state(times)
    close(motion, times, theta - angle, rate - slope)
