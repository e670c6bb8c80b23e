"""Exact motion of the linear oscillator theta'' = -k theta - xi theta' + A sin(Omega t + phi).

The state is theta, theta_dot, and the sine and cosine of the forcing. A power series gives the
exponential of its matrix after a time so short that 34 digits are exact. Squaring the exponential
doubles the time. The roots of the equation may lie anywhere, as at critical damping or resonance.
"""

from __future__ import annotations

import math

import numpy as np

from plumbob.analytic.numerics.quad import Quad, double, quad
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.reference import Array

SERIES_TERMS = 22  # terms of a series in |z t| <= 1/8: the next term is below 1e-38


def linear_motion(
    rotor: DrivenRotor, theta: float, theta_dot: float, times: Array
) -> tuple[Array, Array]:
    """Returns theta [rad] and theta_dot [rad/s] of a linear `rotor` at `times` [s].

    The motion starts at `theta` [rad] and `theta_dot` [rad/s]. `times` may have any shape and are
    not negative.
    """
    rate = math.sqrt(abs(rotor.stiffness)) + rotor.damping_rate + abs(rotor.forcing_frequency)
    largest_phase = rate * float(np.max(times, initial=0.0))
    doublings = max(0, math.ceil(math.log2(8 * largest_phase or 1.0)))
    push = rotor.forcing_amplitude
    phase = quad(rotor.forcing_phase)
    start = np.array([quad(theta), quad(theta_dot), push * np.sin(phase), push * np.cos(phase)])
    size = 4 if push else 2  # without forcing the state is theta and theta_dot alone
    start = start[:size, None, None]
    time = quad(np.ravel(times).astype(float)) / quad(2.0**doublings)
    matrix = quad(_matrix(rotor)[:size, :size])
    powers = [quad(np.eye(size))]  # power n of the matrix, divided by n!
    for n in range(1, SERIES_TERMS + 1):
        powers.append(_product(matrix, powers[-1]) / n)
    flow = quad(0.0)
    for power in reversed(powers):
        flow = flow * time + power[..., None]
    for _ in range(doublings):
        flow[:2] = _product(flow[:2], flow)
        flow[2:, 2:] = _product(flow[2:, 2:], flow[2:, 2:])
    state = double(_product(flow[:2], start)).reshape(2, *np.shape(times))
    return state[0], state[1]


def _matrix(rotor: DrivenRotor) -> Array:
    """Returns the matrix of the equation for theta, theta_dot, and the forcing's sine and cosine,
    shape (4, 4)."""
    k = rotor.stiffness
    damping = rotor.damping_rate
    frequency = rotor.forcing_frequency
    return np.array(
        [[0, 1, 0, 0], [-k, -damping, 1, 0], [0, 0, 0, frequency], [0, 0, -frequency, 0]],
        dtype=np.float64,
    )


def _product(left: Quad, right: Quad) -> Quad:
    """Returns the product of two stacks of matrices, whose matrices are along the first two axes.

    numpy's own product is wrong for stacks of 34-digit numbers. Sums of parts that have decayed to
    zero raise a floating-point flag without cause, which is ignored.
    """
    with np.errstate(invalid="ignore"):
        return sum(left[:, k, None] * right[k] for k in range(left.shape[1]))
