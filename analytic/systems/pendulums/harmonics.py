"""The Fourier series of a pendulum's motion, and how many harmonics an accuracy takes.

Sudakov 2015 calls Fourier series simpler and more exact than elliptic functions. Their coefficients
fall as e^(-n s), s being Omega times the distance of the motion's nearest singularity from the real
time axis. That distance hardly changes with the energy, but Omega falls to zero at a separatrix, as
1/ln: the number of harmonics for an accuracy grows with the period, and without bound.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion

SAMPLES = 2**14  # of a period
NOISE = 1e-15  # of an angle: coefficients below it are round-off


def coefficients(motion: PendulumMotion) -> Array:
    """Amplitudes [rad] of the harmonics 1, 2, ... of theta, less Omega t where the motion rotates,
    shape (SAMPLES/2 - 1,)."""
    times = np.linspace(0.0, motion.period, SAMPLES, endpoint=False)
    theta = motion.state(times)[0]
    if motion.regime == "rotation":
        theta = theta - np.sign(motion.theta_dot) * motion.mean_rate * times
    return 2 * np.abs(np.fft.rfft(theta))[1:-1] / SAMPLES


def scale(motion: PendulumMotion) -> float:
    """The reference of an accuracy [rad]: 1 for a rotation, the amplitude of a libration."""
    if motion.regime == "rotation":
        return 1.0
    theta = motion.state(np.linspace(0.0, motion.period, 512, endpoint=False))[0]
    return float(np.ptp(theta)) / 2


def needed(motion: PendulumMotion, accuracies: Sequence[float]) -> tuple[int, ...]:
    """Harmonics after which what is left, the sum of all further amplitudes, is at most each of
    `accuracies`, relative to `scale`."""
    sizes = coefficients(motion)
    sizes[sizes < 4 * NOISE] = 0.0
    left = np.append(np.cumsum(sizes[::-1])[::-1], 0.0) / scale(motion)
    return tuple(int(np.argmax(left <= accuracy)) for accuracy in accuracies)
