"""The Fourier series of a pendulum's motion, and how many harmonics an accuracy needs.

Sudakov 2015 calls Fourier series simpler and more exact than elliptic functions. Their coefficients
fall as e^(-n s). Here s is Omega times the distance of the motion's nearest singularity from the
real time axis. That distance hardly depends on the energy, but Omega falls to zero at a separatrix,
as 1/ln. So the number of harmonics for a given accuracy grows with the period, without bound.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion

PERIOD_SAMPLES = 2**14  # samples of a period
COEFFICIENT_ROUNDOFF = 1e-15  # [rad] round-off of an amplitude


def harmonic_amplitudes(motion: PendulumMotion) -> Array:
    """Returns the amplitudes [rad] of the harmonics 1, 2, ... of theta, shape (PERIOD_SAMPLES/2 -
    1,). For a rotation they are those of theta - Omega t."""
    times = np.linspace(0.0, motion.period, PERIOD_SAMPLES, endpoint=False)
    theta = motion.state(times)[0]
    if motion.regime == "rotation":
        theta = theta - np.sign(motion.theta_dot) * motion.mean_rate * times
    return 2 * np.abs(np.fft.rfft(theta))[1:-1] / PERIOD_SAMPLES


def angle_scale(motion: PendulumMotion) -> float:
    """Returns the angle [rad] to which an accuracy refers: 1 for a rotation, the amplitude for a
    libration."""
    if motion.regime == "rotation":
        return 1.0
    theta = motion.state(np.linspace(0.0, motion.period, 512, endpoint=False))[0]
    return float(np.ptp(theta)) / 2


def harmonics_needed(motion: PendulumMotion, accuracies: Sequence[float]) -> tuple[int, ...]:
    """Returns, for each of `accuracies` relative to `angle_scale`, the number of harmonics after
    which the amplitudes of all further harmonics add up to at most that accuracy."""
    amplitudes = harmonic_amplitudes(motion)
    amplitudes[amplitudes < 4 * COEFFICIENT_ROUNDOFF] = 0.0
    tails = np.append(np.cumsum(amplitudes[::-1])[::-1], 0.0) / angle_scale(motion)
    return tuple(int(np.argmax(tails <= accuracy)) for accuracy in accuracies)
