"""The cone pendulum on a rotating platform: mass properties, Lagrangian and both Hamiltonians.

Sudakov 2015. theta is measured from hanging down, about the axis; the platform turns at a constant
rate about the vertical. Eq. 9 of the source is not the Legendre transform of its Lagrangian (7): it
has T + U, which a prescribed rotation does not conserve. Both are implemented, each under its own
name."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import (
    Kind,
    TrigonometricPotential,
    critical_points,
    kind,
)
from plumbob.analytic.numerics.quad import Quad, double, quad
from plumbob.analytic.parameters import ParameterError, finite, non_negative, positive
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion


@dataclass(frozen=True)
class Body:
    """A rigid body hung on a horizontal axis: mass [kg], distance of its centre of mass from the
    axis [m], and principal moments of inertia about the pivot [kg m^2]. Raises ParameterError."""

    mass: float
    com_distance: float
    inertia_x: float
    inertia_y: float
    inertia_z: float

    def __post_init__(self) -> None:
        for name in ("mass", "com_distance", "inertia_x", "inertia_y", "inertia_z"):
            positive(name, getattr(self, name))
        least = self.mass * self.com_distance**2
        if min(self.inertia_x, self.inertia_y) < least * (1 - 1e-12):
            name = "inertia_x" if self.inertia_x < least else "inertia_y"
            wanted = f"at least mass com_distance^2 = {least:.6g}"
            raise ParameterError(name, getattr(self, name), wanted)
        central = sorted((self.inertia_x - least, self.inertia_y - least, self.inertia_z))
        if central[2] > (central[0] + central[1]) * (1 + 1e-12):
            raise ParameterError(
                "inertia_x, inertia_y, inertia_z",
                (self.inertia_x, self.inertia_y, self.inertia_z),
                "possible: about the centre of mass none may exceed the sum of the other two",
            )


def cone(density: float, height: float, apex_angle: float) -> Body:
    """Solid cone hung by its vertex (Sudakov 2015, eq. 1); density [kg/m^3], height [m], full
    apex angle [rad]. Raises ParameterError."""
    positive("density", density), positive("height", height)
    if not 0.0 < finite("apex_angle", apex_angle) < math.pi:
        raise ParameterError("apex_angle", apex_angle, "between 0 and pi radians")
    tan2 = math.tan(apex_angle / 2) ** 2
    mass = math.pi / 3 * density * height**3 * tan2
    across = 0.15 * mass * height**2 * (4 + tan2)
    return Body(mass, 0.75 * height, across, across, 0.3 * mass * height**2 * tan2)


@dataclass(frozen=True)
class Equilibrium:
    """An angle [rad] of relative rest, its potential [J], its kind, and the rate of small motion:
    [rad/s] of the oscillation about a centre, [1/s] of the departure from a saddle."""

    theta: float
    potential: float
    kind: Kind
    rate: float


@dataclass(frozen=True)
class ConePendulum:
    """A body on an axis at (pivot_x, pivot_y) [m] of a platform that turns at platform_rate
    [rad/s], under gravity [m/s^2], started at theta [rad] with theta_dot [rad/s], or with `excess`
    [J] above the highest barrier in the direction of theta_dot. Raises ParameterError.

    >>> from math import radians
    >>> body = cone(density=1000.0, height=0.3, apex_angle=radians(30.0))
    >>> pendulum = ConePendulum(body, 0.0, 0.0, 4.0, gravity=9.8, theta=0.5, theta_dot=0.0)
    >>> pendulum.motion.regime, round(pendulum.motion.period, 6)
    ('libration', 1.24948)
    """

    body: Body
    pivot_x: float
    pivot_y: float
    platform_rate: float
    gravity: float
    theta: float
    theta_dot: float
    excess: float | None = None

    def __post_init__(self) -> None:
        for name in ("pivot_x", "pivot_y", "platform_rate", "theta", "theta_dot"):
            finite(name, getattr(self, name))
        non_negative("gravity", self.gravity)
        if self.excess is not None:
            finite("excess", self.excess)
            _ = self.motion

    @property
    def potential(self) -> TrigonometricPotential:
        """V of H = p^2/(2 I_x) + V, the Legendre transform of Sudakov 2015, eq. 7, in 34 digits.

        a = (I_y - I_z) omega^2 / 2: the source's I_x for I_y holds for a symmetric body alone.
        """
        body, rate2 = self.body, quad(self.platform_rate) ** 2
        arm = quad(body.mass) * body.com_distance
        spread = quad(body.inertia_y) - quad(body.inertia_z)
        return TrigonometricPotential(
            spread * rate2 / 2, arm * self.pivot_y * rate2, arm * self.gravity
        )

    @property
    def printed_potential(self) -> TrigonometricPotential:
        """V as printed in Sudakov 2015, eq. 9: the centrifugal terms with the wrong sign."""
        v = self.potential
        return TrigonometricPotential(-v.a, -v.b, v.c)

    @cached_property
    def motion(self) -> PendulumMotion:
        """The exact motion."""
        return PendulumMotion(
            self.potential, self.body.inertia_x, self.theta, self.theta_dot, self.excess
        )

    def printed_motion(self, theta_dot: float | None = None) -> PendulumMotion:
        """The motion that the printed eqs. 9, 15 and 16 describe, from the same start or from
        another theta_dot [rad/s]: for the paper's figures and for the finding alone."""
        speed = self.theta_dot if theta_dot is None else theta_dot
        return PendulumMotion(self.printed_potential, self.body.inertia_x, self.theta, speed)

    @property
    def started(self) -> ConePendulum:
        """The same problem with theta_dot given in place of `excess`, rounded to double."""
        if self.excess is None:
            return self
        speed = float(self.motion.momentum(np.array(self.theta))) / self.body.inertia_x
        return replace(self, theta_dot=speed, excess=None)

    @property
    def equilibria(self) -> tuple[Equilibrium, ...]:
        """Relative equilibria in (-pi, pi], ascending."""
        v = self.potential
        points = critical_points(v)
        return tuple(self._equilibrium(v, p) for p in points[np.isfinite(double(points))])

    def _equilibrium(self, potential: TrigonometricPotential, theta: Quad) -> Equilibrium:
        stiffness = abs(float(double(potential.curvature(theta))))
        sort = kind(potential, theta)
        rate = 0.0 if sort == "degenerate" else math.sqrt(stiffness / self.body.inertia_x)
        value = float(double(potential.value(theta)))
        return Equilibrium(float(double(theta)), value, sort, rate)

    @property
    def printed_barrier(self) -> tuple[float, float]:
        """Largest printed potential [J], which the source reads off Figs. 2a and 3a, and its angle
        [rad]."""
        v = self.printed_potential
        points = critical_points(v)
        points = points[np.isfinite(double(points))]
        if not points.size:
            return float(double(v.value(quad(0.0)))), 0.0
        values = double(v.value(points))
        return float(values.max()), float(double(points[values.argmax()]))

    @property
    def pitchfork_rate(self) -> float:
        """Platform rate [rad/s] at which hanging down stops being stable when pivot_y = 0; infinite
        where it never does."""
        spread = self.body.inertia_y - self.body.inertia_z
        weight = self.body.mass * self.body.com_distance * self.gravity
        return math.sqrt(weight / spread) if spread > 0.0 else math.inf
