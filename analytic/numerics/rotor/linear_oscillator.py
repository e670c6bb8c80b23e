"""The linear oscillator theta'' = -k theta - xi theta' + A sin(Omega t + phi) in closed form.

Written with divided differences of exp(z t) over the characteristic roots z1, z2 and i Omega, which
are smooth where roots meet: nothing cancels near critical damping, near resonance or at small t.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from plumbob.analytic.numerics.arithmetic import two_product, two_sum
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.parameters import finite, non_negative
from plumbob.analytic.reference import Array

Complex = npt.NDArray[np.complex128]
TERMS = 24  # of a series in |z t| <= 1: the next one is below 1e-22


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
        t = np.asarray(times, dtype=float)
        from_angle, swing, swing_dot = _free(_Roots.of(self), t)
        x = theta * from_angle + theta_dot * swing
        v = theta_dot * swing_dot - self.stiffness * theta * swing
        if self.forcing_amplitude == 0.0:
            return x, v
        # a negative frequency is a positive one with the signs of amplitude and phase changed
        sign = math.copysign(1.0, self.forcing_frequency)
        answer, answer_dot = _forced(self, abs(self.forcing_frequency), t)
        turn = sign * self.forcing_amplitude * np.exp(1j * sign * self.forcing_phase)
        return x + (turn * answer).imag, v + (turn * answer_dot).imag


def linear_oscillator(rotor: DrivenRotor) -> LinearOscillator | None:
    """The equation of a rotor as a linear oscillator; None where it is not one."""
    if not rotor.linear:
        return None
    names = (field.name for field in fields(LinearOscillator))
    return LinearOscillator(**{name: getattr(rotor, name) for name in names})


@dataclass(frozen=True)
class _Roots:
    """Roots of z^2 + xi z + k: middle +- split, split real or imaginary, with their roundings."""

    middle: float  # -xi / 2
    split: float  # sqrt|xi^2/4 - k|
    split_low: float
    oscillating: bool
    slow: float  # the larger real root, formed without cancellation; overdamped only

    @classmethod
    def of(cls, oscillator: LinearOscillator) -> _Roots:
        half, k = oscillator.damping_rate / 2, oscillator.stiffness
        square, square_low = two_product(half, half)
        discriminant, carry = two_sum(square, -k)
        discriminant, low = two_sum(discriminant, carry + square_low)
        split = math.sqrt(abs(discriminant))
        split_low = 0.0
        if split > 0.0:
            again, again_low = two_product(split, split)
            remainder = (
                math.copysign(1.0, discriminant) * low + (abs(discriminant) - again) - again_low
            )
            split_low = remainder / (2 * split)
        slow = -k / (half + split) if discriminant > 0.0 else -half
        return cls(-half, split, split_low, discriminant <= 0.0, slow)

    @property
    def near(self) -> tuple[complex, complex]:
        """The root nearest to positive imaginary frequencies, and its rounding."""
        if self.oscillating:
            return complex(self.middle, self.split), complex(0.0, self.split_low)
        return complex(self.slow), 0j

    @property
    def far(self) -> complex:
        """The other root."""
        return complex(self.middle, -self.split) if self.oscillating else self.middle - self.split


def _free(roots: _Roots, t: Array) -> tuple[Array, Array, Array]:
    """Free motion from (1, 0); free motion from (0, 1) and its rate."""
    half = -roots.middle
    if roots.oscillating:
        envelope = np.exp(roots.middle * t)
        phase, low = two_product(np.full_like(t, roots.split), t)
        low = low + roots.split_low * t
        sine = np.sin(phase) + low * np.cos(phase)
        cosine = np.cos(phase) - low * np.sin(phase)
        swing = sine / (roots.split + roots.split_low) if roots.split > 0.0 else t
        return (
            envelope * (cosine + half * swing),
            envelope * swing,
            envelope * (cosine - half * swing),
        )
    fast = np.exp((roots.middle - roots.split) * t)
    slow = np.exp(roots.slow * t)
    swing = -slow * np.expm1(-2 * roots.split * t) / (2 * roots.split)
    return slow - roots.slow * swing, swing, fast + roots.slow * swing


def _forced(oscillator: LinearOscillator, frequency: float, t: Array) -> tuple[Complex, Complex]:
    """Motion from rest under exp(i frequency t), and its rate: the divided differences of exp(z t)
    and z exp(z t) over both roots and i frequency."""
    roots, drive = _Roots.of(oscillator), 1j * frequency
    _, swing, swing_dot = _free(roots, t)
    at_near, pair = _pair(roots, drive, t)
    spread = drive - roots.far
    early = abs(spread) * t < 1.0  # every root times t is then below one
    with np.errstate(divide="ignore", invalid="ignore"):
        answer = (pair - swing) / spread
        answer_dot = (drive * pair + at_near - swing_dot) / spread
    series, series_dot = _early(oscillator, drive, np.where(early, t, 0.0))
    return np.where(early, series, answer), np.where(early, series_dot, answer_dot)


def _pair(roots: _Roots, drive: complex, t: Array) -> tuple[Complex, Complex]:
    """exp(z t) at the near root, and its divided difference with that at `drive`."""
    near, near_low = roots.near
    at_drive = _exponential(drive, 0j, t)
    at_near = _exponential(near, near_low, t)
    gap = (near - drive) + near_low
    close = np.abs(gap * t) < 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = (at_near - at_drive) / gap
        pair = np.where(close, t * at_drive * _phi1(np.where(close, gap * t, 0)), apart)
    return at_near, pair


def _exponential(rate: complex, rate_low: complex, t: Array) -> Complex:
    """exp((rate + rate_low) t) without the rounding of the phase."""
    phase, low = two_product(np.full_like(t, rate.imag), t)
    total = np.exp(rate.real * t + 1j * phase)
    return total * (1 + 1j * low + rate_low * t)


def _phi1(z: Complex) -> Complex:
    """(exp(z) - 1) / z for |z| <= 1."""
    return _polynomial([1.0 / math.factorial(n) for n in range(1, TERMS)], z)


def _polynomial(terms: Sequence[complex], z: Array | Complex) -> Complex:
    total = np.zeros(np.shape(z), dtype=complex)
    for term in reversed(terms):
        total = total * z + term
    return total


def _early(oscillator: LinearOscillator, drive: complex, t: Array) -> tuple[Complex, Complex]:
    """The forced motion by its Taylor series, for |z t| <= 1."""
    terms = [0j, 0j]
    source = 1 + 0j
    for n in range(TERMS):
        a = source - oscillator.stiffness * terms[n]
        a -= oscillator.damping_rate * (n + 1) * terms[n + 1]
        terms.append(a / ((n + 1) * (n + 2)))
        source *= drive / (n + 1)
    slopes = [n * term for n, term in enumerate(terms)][1:]
    return _polynomial(terms, t), _polynomial(slopes, t)
