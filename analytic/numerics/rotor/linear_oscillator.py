"""The linear oscillator theta'' = -k theta - xi theta' + A sin(Omega t + phi), exactly.

Power series give the free motions and those from rest under cos(Omega t) and sin(Omega t) after a
time so short that 34 digits are exact, and each doubling of the time composes them: the roots of
the equation may lie anywhere, as at critical damping or at resonance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from plumbob.analytic.numerics.quad import Quad, double, quad
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.parameters import finite, non_negative
from plumbob.analytic.reference import Array

TERMS = 22  # of a series in |z t| <= 1/8: the next one is below 1e-38
State = tuple[Any, Any]  # angle and rate, in 34 digits


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
        time = quad(np.asarray(times, dtype=float)) / quad(2.0**doublings)
        free = self._series(time, (1, 0), 0, 0), self._series(time, (0, 1), 0, 0)
        forced = self._series(time, (0, 0), 1, 0), self._series(time, (0, 0), 0, 1)
        for _ in range(doublings):
            if self.forcing_amplitude:
                angle = quad(self.forcing_frequency) * time
                forced = _both(free, forced, np.cos(angle), np.sin(angle))
            free, time = (_sum(free, *free[0]), _sum(free, *free[1])), 2 * time
        push, phase = quad(self.forcing_amplitude), quad(self.forcing_phase)
        x, v = _sum(
            (_sum(free, quad(theta), quad(theta_dot)), *forced),
            1,
            push * np.sin(phase),
            push * np.cos(phase),
        )
        return np.asarray(double(x)), np.asarray(double(v))

    def _series(self, time: Quad, start: tuple[int, int], cosine: int, sine: int) -> State:
        """Angle and rate after a short `time` [s] from `start`, under the sum of `cosine` times
        cos(Omega t) and `sine` times sin(Omega t)."""
        stiffness, damping = quad(self.stiffness), quad(self.damping_rate)
        frequency = quad(self.forcing_frequency)
        terms = [quad(number) for number in start]
        wave = quad(cosine), quad(sine) * frequency  # the n-th term, and the next one times n + 1
        for n in range(TERMS):
            bend = wave[0] - stiffness * terms[n] - damping * (n + 1) * terms[n + 1]
            terms.append(bend / ((n + 1) * (n + 2)))
            wave = wave[1] / (n + 1), -wave[0] * frequency * frequency / (n + 1)
        x = v = 0 * time
        for n in reversed(range(TERMS + 1)):
            x, v = x * time + terms[n], v * time + (n + 1) * terms[n + 1]
        return x, v


def _both(
    free: tuple[State, State], forced: tuple[State, State], cosine: Quad, sine: Quad
) -> tuple[State, State]:
    """The motions from rest under cos(Omega t) and sin(Omega t) after twice the time, at which
    Omega t has `cosine` and `sine`."""
    by_cosine, by_sine = ((_sum(free, *state), *forced) for state in forced)
    return _sum(by_cosine, 1, cosine, -sine), _sum(by_sine, 1, sine, cosine)


def _sum(states: Sequence[State], *factors: Any) -> State:
    pairs = list(zip(states, factors, strict=True))
    return sum(f * x for (x, _), f in pairs), sum(f * v for (_, v), f in pairs)


def linear_oscillator(rotor: DrivenRotor) -> LinearOscillator | None:
    """The equation of a rotor as a linear oscillator; None where it is not one."""
    if not rotor.linear:
        return None
    names = (field.name for field in fields(LinearOscillator))
    return LinearOscillator(**{name: getattr(rotor, name) for name in names})
