"""The linear oscillator theta'' = -k theta - xi theta' + A sin(Omega t + phi), exactly.

A power series gives the exponential of the matrix of theta, theta_dot and the sine and cosine of
the forcing after a time so short that 34 digits are exact, and each doubling of the time squares
it: the roots of the equation may lie anywhere, as at critical damping or at resonance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from plumbob.analytic.numerics.quad import Quad, double, quad
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.parameters import finite, non_negative
from plumbob.analytic.reference import Array

TERMS = 22  # of a series in |z t| <= 1/8: the next one is below 1e-38


@dataclass(frozen=True)
class LinearOscillator:
    """Coefficients: stiffness [1/s^2] (any sign), damping_rate [1/s], forcing_amplitude [rad/s^2],
    forcing_frequency [rad/s], forcing_phase [rad]. Raises ParameterError."""

    stiffness: float
    damping_rate: float = 0.0
    forcing_amplitude: float = 0.0
    forcing_frequency: float = 0.0
    forcing_phase: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            finite(field.name, getattr(self, field.name))
        non_negative("damping_rate", self.damping_rate)

    @property
    def rotor(self) -> DrivenRotor:
        """The same equation as a driven rotor, for the error theory."""
        return DrivenRotor(**{field.name: getattr(self, field.name) for field in fields(self)})

    def motion(self, theta: float, theta_dot: float, times: Array) -> tuple[Array, Array]:
        """Theta [rad] and theta_dot [rad/s] at `times` [s], any shape, not negative, from `theta`
        [rad] and `theta_dot` [rad/s]."""
        rate = math.sqrt(abs(self.stiffness)) + self.damping_rate + abs(self.forcing_frequency)
        longest = rate * float(np.max(times, initial=0.0))
        doublings = max(0, math.ceil(math.log2(8 * longest or 1.0)))
        push, phase = self.forcing_amplitude, quad(self.forcing_phase)
        numbers = 4 if push else 2
        time = quad(np.asarray(times, dtype=float))[..., None, None] / quad(2.0**doublings)
        part = quad(self._matrix[:numbers, :numbers]) * time
        flow = unit = quad(np.eye(numbers))
        for n in range(TERMS, 0, -1):
            flow = unit + _product(part, flow) / n
        for _ in range(doublings):
            flow = _product(flow, flow)
        start = np.array([quad(theta), quad(theta_dot), push * np.sin(phase), push * np.cos(phase)])
        x, v = np.moveaxis(double(_product(flow, start[:numbers, None])), -2, 0)[:2, ..., 0]
        return x, v

    @property
    def _matrix(self) -> Array:
        """The derivatives of the rates by theta, theta_dot, and the forcing's sine and cosine."""
        k, damping, frequency = self.stiffness, self.damping_rate, self.forcing_frequency
        return np.array(
            [[0, 1, 0, 0], [-k, -damping, 1, 0], [0, 0, 0, frequency], [0, 0, -frequency, 0]],
            dtype=np.float64,
        )


def _product(left: Quad, right: Quad) -> Quad:
    """Of matrices: numpy's own is wrong of stacks of 34 digits."""
    return (left[..., None] * right[..., None, :, :]).sum(axis=-2)


def linear_oscillator(rotor: DrivenRotor) -> LinearOscillator | None:
    """The equation of a rotor as a linear oscillator; None where it is not one."""
    if not rotor.linear:
        return None
    names = (field.name for field in fields(LinearOscillator))
    return LinearOscillator(**{name: getattr(rotor, name) for name in names})
