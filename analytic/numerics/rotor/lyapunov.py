"""Divergence of neighbouring motions: the Lyapunov exponent."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.taylor_series import integrate
from plumbob.analytic.numerics.rotor.variational import TangentFlow
from plumbob.analytic.parameters import positive
from plumbob.analytic.reference import Array

BATCHES = 16


@dataclass(frozen=True)
class LyapunovExponent:
    """Largest Lyapunov exponent [1/s] and its standard error [1/s], from the scatter of batches."""

    value: float
    standard_error: float


def largest_exponent(
    rotor: DrivenRotor,
    theta: float,
    theta_dot: float,
    duration: float = 2000.0,
    transient: float = 100.0,
) -> LyapunovExponent:
    """Mean rate of divergence of motions near the one from `theta` [rad], `theta_dot` [rad/s] over
    `duration` [s] after `transient` [s] (Benettin et al. 1980, Meccanica 15, 9). Raises
    ParameterError.

    A chaotic orbit of this length is not the one that the start determines, but it is as typical.
    """
    positive("duration", duration)
    orbit = integrate(rotor, theta, theta_dot, transient + duration)
    logarithms = _growth_logarithms(TangentFlow(rotor, orbit).transitions, rotor.rate())
    inside = orbit.breakpoints[:-1] >= transient
    lengths, logs = np.diff(orbit.breakpoints)[inside], logarithms[inside]
    batches = np.array_split(np.arange(len(logs)), BATCHES)
    rates = np.array([logs[batch].sum() / lengths[batch].sum() for batch in batches])
    return LyapunovExponent(
        float(logs.sum() / lengths.sum()), float(rates.std(ddof=1) / math.sqrt(BATCHES))
    )


def _growth_logarithms(transitions: Array, rate: float) -> Array:
    """Logarithm of the growth over each step of a tangent vector, theta_dot measured by `rate`."""
    vector, logarithms = np.array([1.0, 0.0]), np.empty(len(transitions))
    for n, transition in enumerate(transitions):
        vector = transition @ vector
        length = math.hypot(vector[0], vector[1] / rate)
        logarithms[n] = math.log(length)
        vector = vector / length
    return logarithms
