"""The equation of motion of all pendulums: an angle in a potential, damped and forced.

    theta'' = p2 sin 2theta + pc cos theta - ps sin theta - k theta
              - xi theta' + A sin(Omega t + phi)

Cone pendulum (Sudakov 2015, eq. 7): p2 = a/I_x, pc = b/I_x, ps = c/I_x. Simple pendulum (Pendulo
Simples): ps = g/L. Linear oscillator: k alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.smooth.smooth_system import IMAGINARY_STEP
from plumbob.analytic.parameters import check_fields
from plumbob.analytic.reference import Array


@dataclass(frozen=True)
class DrivenRotor:
    """Coefficients of the equation. Raises ParameterError for a value that is not finite, or for
    negative damping."""

    sin2: float = 0.0  # p2 [rad/s^2]
    cos: float = 0.0  # pc [rad/s^2]
    sin: float = 0.0  # ps [rad/s^2]
    damping_rate: float = 0.0  # xi [1/s]
    forcing_amplitude: float = 0.0  # A [rad/s^2]
    forcing_frequency: float = 0.0  # Omega [rad/s]
    forcing_phase: float = 0.0  # phi [rad]
    stiffness: float = 0.0  # k [1/s^2]

    def __post_init__(self) -> None:
        check_fields(self, (), ("damping_rate",))

    @property
    def autonomous(self) -> bool:
        """Whether the equation does not depend on time."""
        return self.forcing_amplitude == 0.0

    @property
    def linear(self) -> bool:
        """Whether the equation is linear: the potential has no periodic part."""
        return not (self.sin2 or self.cos or self.sin)

    @property
    def conservative(self) -> bool:
        """Whether the energy is a constant of the motion."""
        return self.autonomous and self.damping_rate == 0.0

    def forcing(self, times: Any) -> Any:
        """Returns the angular acceleration [rad/s^2] by the forcing alone at `times` [s]."""
        return self.forcing_amplitude * np.sin(
            self.forcing_frequency * times + self.forcing_phase
        )

    def acceleration(self, times: Any, theta: Any, theta_dot: Any) -> Any:
        """Returns the angular acceleration [rad/s^2] at `times` [s], `theta` [rad] and `theta_dot`
        [rad/s]; numbers, arrays or complex arrays."""
        return rotor_acceleration(self)(self, times, (theta,), (theta_dot,))[0]

    def slope(self, theta: Array | float) -> Array:
        """Returns the partial derivative of the acceleration by theta [1/s^2].

        The derivative by theta_dot is -damping_rate for any state.
        """
        return np.asarray(
            self.acceleration(0.0, theta + 1j * IMAGINARY_STEP, 0.0).imag / IMAGINARY_STEP
        )

    def energy(self, theta: Any, theta_dot: Any) -> Array:
        """Returns the energy per moment of inertia [rad^2/s^2], theta_dot^2/2 + V."""
        well = TrigonometricPotential(self.sin2, self.cos, self.sin).value(theta)
        well = well + 0.5 * self.stiffness * np.square(theta)
        return np.asarray(0.5 * np.square(theta_dot) + well)

    def rate(self) -> float:
        """Returns a bound on the rate of change of a motion near rest [1/s]."""
        stiffness = 2 * abs(self.sin2) + abs(self.cos) + abs(self.sin) + abs(self.stiffness)
        forced = 0.0 if self.autonomous else abs(self.forcing_frequency)
        return math.sqrt(stiffness) + self.damping_rate + forced


def rotor_acceleration(rotor: DrivenRotor, library: Any = np) -> Callable[..., tuple[Any]]:
    """Returns the acceleration of a `rotor` as a function of coefficients, time, angle and rate.

    The function works in any arithmetic for which `library` has a sine and a cosine. Terms that are
    zero on `rotor` are left out.
    """

    linear = rotor.linear
    autonomous = rotor.autonomous

    def acceleration(p: Any, t: Any, q: Any, v: Any) -> tuple[Any]:
        """Returns theta'' from the coefficients p, the time t, the angle and the rate."""
        (theta,) = q
        (rate,) = v
        total: Any = 0.0
        if not linear:
            sine = library.sin(theta)
            total = (2.0 * p.sin2 * sine + p.cos) * library.cos(theta) - p.sin * sine
        total = total - p.stiffness * theta - p.damping_rate * rate
        if not autonomous:
            push = library.sin(p.forcing_frequency * t + p.forcing_phase)
            total = total + p.forcing_amplitude * push
        return (total,)

    return acceleration
