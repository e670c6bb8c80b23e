"""The simple pendulum: a point mass on a rigid rod, damped and forced, or its linear companion.

Pendulo Simples, per unit mass as in its code:

    theta'' = A sin(Omega t) - xi theta' - (g/L) sin theta,    T = m L theta'^2 + m g cos theta,

with theta from hanging down. Its equations have m L theta'' + C L theta' + m g sin theta = F(t), so
xi = C/m and A = F_0/(m L). The notebook calls xi = C/m a damping ratio; it is a rate, in 1/s. The
linear companion has theta in place of sin theta.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import PI, double, quad
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.orbit import smooth_system
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.parameters import ParameterError, check_fields, finite
from plumbob.analytic.reference import Reference
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.analytic.systems.pendulums.rod_tension import MASS, RodMotion, tension


@dataclass(frozen=True)
class SimplePendulum:
    """A point of `mass` [kg] at `length` [m] under `gravity` [m/s^2], damped at damping_rate [1/s],
    forced with forcing_amplitude [rad/s^2] at forcing_frequency [rad/s], started at theta [rad]
    with theta_dot [rad/s]. If `linear`, theta replaces sin theta in the equation. Raises
    ParameterError.

    Near the top, theta as a double has few digits of the distance from the top. There
    `theta_from_top` [rad], the initial angle from pi, may replace theta, unless the pendulum is
    linear, damped or forced.

    >>> import math, numpy as np
    >>> pendulum = SimplePendulum(1.0, 9.81, 0.0, 0.0, 0.0, theta=math.pi / 2, theta_dot=0.0)
    >>> seen = pendulum.motion.observe(np.array([pendulum.elliptic.period / 4]))
    >>> print(f"{seen['theta_dot'][0]:.6f} rad/s, {seen['tension'][0]:.2f} N")
    -4.429447 rad/s, 29.43 N
    """

    length: float
    gravity: float
    damping_rate: float
    forcing_amplitude: float
    forcing_frequency: float
    theta: float
    theta_dot: float
    linear: bool = False
    theta_from_top: float | None = None
    mass: float = MASS

    def __post_init__(self) -> None:
        others = "linear", "theta_from_top"
        check_fields(self, ("length", "mass"), ("gravity", "damping_rate"), others)
        if self.theta_from_top is not None:
            finite("theta_from_top", self.theta_from_top)
            if self.linear or not self.rotor.conservative or not self.gravity:
                need = "left out, for theta, where it is linear, damped, forced or weightless"
                raise ParameterError("theta_from_top", self.theta_from_top, need)

    @property
    def started(self) -> SimplePendulum:
        """This problem with theta rounded to double in place of `theta_from_top`, as an engine
        starts it."""
        if self.theta_from_top is None:
            return self
        return replace(self, theta=float(double(PI + self.theta_from_top)), theta_from_top=None)

    @property
    def rotor(self) -> DrivenRotor:
        """The equation of motion."""
        pull = self.gravity / self.length
        return DrivenRotor(
            sin=0.0 if self.linear else pull,
            stiffness=pull if self.linear else 0.0,
            damping_rate=self.damping_rate,
            forcing_amplitude=self.forcing_amplitude,
            forcing_frequency=self.forcing_frequency,
        )

    @property
    def system(self) -> SmoothSystem:
        """The equation of motion with its start and, unless linear, the tension of the rod."""
        start = self.started
        system = smooth_system(self.rotor, start.theta, start.theta_dot)
        if self.linear:
            return system
        rod = {"length": self.length, "gravity": self.gravity, "mass": self.mass}
        return replace(
            system,
            parameters={**system.parameters, **rod},
            readings=lambda p, q, v: {
                "tension": tension(p.length, p.gravity, q[0], v[0], p.mass)
            },
        )

    @property
    def elliptic(self) -> PendulumMotion | None:
        """The motion by Jacobi functions, or None if the equation is linear, damped or forced. It
        is for 1 kg; only energy and action depend on the mass."""
        if self.linear or not self.rotor.conservative:
            return None
        return PendulumMotion(
            TrigonometricPotential(0.0, 0.0, quad(self.length) * self.gravity),
            self.length**2,
            self.theta,
            self.theta_dot,
            theta_from_top=self.theta_from_top,
        )

    @cached_property
    def motion(self) -> Reference:
        """The exact motion; unless linear, with the tension of the rod."""
        start = self.started
        motion: Reference | None = self.elliptic
        if motion is None:
            motion = DrivenMotion(self.rotor, start.theta, start.theta_dot)
        return motion if self.linear else RodMotion(motion, self.system)
