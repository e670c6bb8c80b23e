"""The linear oscillator theta'' = -k theta - xi theta' + A sin(Omega t + phi), exactly.

A power series gives the exponential of the matrix of theta, theta_dot and the sine and cosine of
the forcing after a time so short that 34 digits are exact, and each doubling of the time squares
it: the roots of the equation may lie anywhere, as at critical damping or at resonance.
"""

from __future__ import annotations

import math

import numpy as np

from plumbob.analytic.numerics.quad import Quad, double, quad
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.reference import Array

TERMS = 22  # of a series in |z t| <= 1/8: the next one is below 1e-38


def linear_motion(
    rotor: DrivenRotor, theta: float, theta_dot: float, times: Array
) -> tuple[Array, Array]:
    """Theta [rad] and theta_dot [rad/s] of a linear `rotor` at `times` [s], any shape, not
    negative, from `theta` [rad] and `theta_dot` [rad/s]."""
    rate = math.sqrt(abs(rotor.stiffness)) + rotor.damping_rate + abs(rotor.forcing_frequency)
    longest = rate * float(np.max(times, initial=0.0))
    doublings = max(0, math.ceil(math.log2(8 * longest or 1.0)))
    push, phase = rotor.forcing_amplitude, quad(rotor.forcing_phase)
    numbers = 4 if push else 2
    time = quad(np.asarray(times, dtype=float))[..., None, None] / quad(2.0**doublings)
    part = quad(_matrix(rotor)[:numbers, :numbers]) * time
    flow = unit = quad(np.eye(numbers))
    for n in range(TERMS, 0, -1):
        flow = unit + _product(part, flow) / n
    for _ in range(doublings):
        flow = _product(flow, flow)
    start = np.array([quad(theta), quad(theta_dot), push * np.sin(phase), push * np.cos(phase)])
    x, v = np.moveaxis(double(_product(flow, start[:numbers, None])), -2, 0)[:2, ..., 0]
    return x, v


def _matrix(rotor: DrivenRotor) -> Array:
    """The derivatives of the rates by theta, theta_dot, and the forcing's sine and cosine."""
    k, damping, frequency = rotor.stiffness, rotor.damping_rate, rotor.forcing_frequency
    return np.array(
        [[0, 1, 0, 0], [-k, -damping, 1, 0], [0, 0, 0, frequency], [0, 0, -frequency, 0]],
        dtype=np.float64,
    )


def _product(left: Quad, right: Quad) -> Quad:
    """Of matrices: numpy's own is wrong of stacks of 34 digits."""
    return (left[..., None] * right[..., None, :, :]).sum(axis=-2)
