"""A drive that is not ideal, and Fourier series: against independent integrations.

DRIVEN is made by Lagrange's two equations, with nothing linearised: of TURNING's body on a platform
of inertia A, whose drive returns its rate w to w0 at a `rate`:

    arm = body.mass * body.com_distance
    skew = body.inertia_y - body.inertia_z

    def slopes(time, state):
        theta, theta_dot, w = state
        sine, cosine = math.sin(theta), math.cos(theta)
        j = 2 * arm * pivot_y * sine + skew * sine**2
        j_slope = 2 * arm * pivot_y * cosine + 2 * skew * sine * cosine
        k, k_slope = arm * pivot_x * cosine, -arm * pivot_x * sine
        matrix = [[body.inertia_x, k], [k, A + j]]
        right = [
            j_slope * w**2 / 2 - arm * gravity * sine,
            rate * A * (w0 - w) - j_slope * theta_dot * w - k_slope * theta_dot**2,
        ]
        return [theta_dot, *np.linalg.solve(matrix, right)]

    solve_ivp(slopes, (0, 1), [theta, theta_dot, w0], "DOP853", rtol=1e-12, atol=1e-12).y[::2, -1]
"""

import math

import numpy as np
import pytest

from plumbob.analytic.errors.contact_models.added_inertia import drive_error
from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.systems.cone_pendulum import ConePendulum, cone
from plumbob.analytic.systems.pendulums.harmonics import (
    angle_scale,
    harmonic_amplitudes,
    harmonics_needed,
)
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion

STEEL = cone(8000.0, 0.3, math.radians(30.0))
TURNING = ConePendulum(STEEL, 0.31, 0.09, 26.0, 9.8, 0.2, 37.0)
INERTIA = STEEL.inertia_x
POTENTIAL = TrigonometricPotential(291.1, 222.3, 35.8)  # near the source's at 26 rad/s
SIMPLE = TrigonometricPotential(0.0, 0.0, 9.8)


def action_and_phase(theta, theta_dot):
    """Action [J s] and phase [rad] of a state of a forward rotation, from its energy alone."""
    turns = math.floor(theta / math.tau)
    within = theta - turns * math.tau
    square = theta_dot**2 + 2 * (POTENTIAL.value(within) - POTENTIAL.value(0.0)) / INERTIA
    motion = PendulumMotion(POTENTIAL, INERTIA, 0.0, math.sqrt(square))
    since = float(motion.time_at(np.array([within]))[0])
    return motion.action, math.tau * turns + motion.mean_rate * since


def test_action_and_phase_of_an_undamped_state():
    motion = PendulumMotion(POTENTIAL, INERTIA, 0.0, 60.0)
    times = np.array([0.03, 1.234])
    for time, theta, rate in zip(times, *motion.state(times), strict=True):
        action, phase = action_and_phase(float(theta), float(rate))
        assert action == pytest.approx(motion.action, rel=1e-13)
        assert phase == pytest.approx(float(motion.phase(time)), rel=1e-12)


# For the drive's rate [1/s]: theta [rad] and the platform's rate [rad/s] at 1 s, of a platform of
# 1e5 and of 1e6 kg m^2.
DRIVEN = {
    0.0: ((37.781604217215865, 26.00003232932246), (37.78170609120234, 26.000003230166325)),
    5.0: ((37.78084189974568, 25.99966922840709), (37.781629851373616, 25.999966903967447)),
    50.0: ((37.77860774904648, 25.999852799546943), (37.78140632129842, 25.99998525842129)),
}


@pytest.mark.parametrize("rate", DRIVEN)
def test_a_drive_that_is_not_ideal(rate):
    """What first order leaves is of the next: ten times smaller for ten times the inertia. Its
    size, at most 50 (theta) and 200 (the small rate) times J/A, is measured."""
    time = 1.0
    gaps = []
    off = []
    exact = float(TURNING.reference.state(np.array([time]))[0][0])
    for inertia, (theta, w) in zip((1e5, 1e6), DRIVEN[rate], strict=True):
        found = drive_error(TURNING, np.array([0.5, time]), inertia, rate)
        gaps.append(float(found.theta[1]) / (theta - exact) - 1.0)
        off.append(float(found.platform_rate[1]) / (w - 26.0) - 1.0)
        assert abs(gaps[-1]) < 50 * 1.7 / inertia
        assert abs(off[-1]) < 200 * 1.7 / inertia
    # theta - exact is known to some 1e-10 of 1e-5
    assert gaps[1] == pytest.approx(gaps[0] / 10, rel=0.1, abs=1e-5)
    assert off[1] == pytest.approx(off[0] / 10, rel=0.1, abs=1e-6)


def test_coefficients_of_the_simple_pendulum():
    """A libration's are 8 q^(n/2)/(n (1 + q^n)) for odd n, q the nome (Whittaker and Watson)."""
    amplitude = 2.5
    motion = PendulumMotion(SIMPLE, 1.0, amplitude, 0.0)
    k = math.sin(amplitude / 2)

    def quarter(modulus):
        a = 1.0
        b = math.sqrt(1.0 - modulus**2)
        for _ in range(40):
            a, b = (a + b) / 2, math.sqrt(a * b)
        return math.pi / (2 * a)

    nome = math.exp(-math.pi * quarter(math.sqrt(1 - k * k)) / quarter(k))
    found = harmonic_amplitudes(motion)
    for n in (1, 3, 5, 7):
        assert found[n - 1] == pytest.approx(
            8 * nome ** (n / 2) / (n * (1 + nome**n)), rel=1e-11
        )
    assert (found[1:8:2] < 1e-13).all()


@pytest.mark.parametrize("speed", [37.0, 60.0])
def test_so_many_harmonics_are_enough_and_one_less_is_not(speed):
    motion = PendulumMotion(POTENTIAL, INERTIA, 0.0, speed)
    times = motion.period * np.linspace(0.0, 1.0, 800, endpoint=False)
    theta = motion.state(times)[0] - motion.mean_rate * times
    series = np.fft.rfft(theta) / len(times)
    sizes = harmonic_amplitudes(motion)
    for accuracy, count in zip(
        (1e-3, 1e-6, 1e-9), harmonics_needed(motion, (1e-3, 1e-6, 1e-9)), strict=True
    ):
        kept = np.where(np.arange(len(series)) <= count, series, 0.0)
        left = np.abs(np.fft.irfft(kept, len(times)) * len(times) - theta).max()
        assert left <= accuracy * angle_scale(motion)
        assert sizes[count - 1 :].sum() > accuracy
    assert harmonics_needed(motion, (1e-12,))[0] > harmonics_needed(motion, (1e-3,))[0]
