"""A double pendulum of two points on massless rods, by its mass matrix and forces."""

import numpy as np

from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem

NAMES = ("theta_1", "theta_2", "theta_1_dot", "theta_2_dot")
CONSTANTS = ("mass_1", "mass_2", "length_1", "length_2", "gravity")


def mass_matrix(p, q):
    """Of the angles from the vertical."""
    first, second = q
    coupling = p.mass_2 * p.length_1 * p.length_2 * np.cos(first - second)
    outer = p.mass_2 * p.length_2**2
    return ((p.mass_1 + p.mass_2) * p.length_1**2, coupling), (coupling, outer)


def forces(p, time, q, v):
    """Moments about the two joints."""
    (first, second), (u, w) = q, v
    pull = p.mass_2 * p.length_1 * p.length_2 * np.sin(first - second)
    weight = (p.mass_1 + p.mass_2) * p.gravity * p.length_1 * np.sin(first)
    return -pull * w**2 - weight, pull * u**2 - p.mass_2 * p.gravity * p.length_2 * np.sin(
        second
    )


def double_pendulum(constants=(1.0, 1.0, 1.0, 1.0, 9.81), start=(1.5, 2.5, 0.0, 0.0)):
    """Two masses [kg], lengths [m] and gravity [m/s^2]; angles [rad] and rates [rad/s] at time
    0."""
    parameters = dict(zip(CONSTANTS, constants, strict=True))
    return SmoothSystem(
        NAMES[:2], NAMES[2:], mass_matrix, forces, parameters, start[:2], start[2:]
    )
