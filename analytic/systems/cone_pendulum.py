"""The cone pendulum on a rotating platform: mass properties, Lagrangian and both Hamiltonians.

Sudakov 2015. theta is measured from hanging down, about the axis; the platform turns at a constant
rate about the vertical. Eq. 9 of the source is not the Legendre transform of its Lagrangian (7): it
has T + U, which a prescribed rotation does not conserve. Both are implemented, each under its own
name.

The source adds that the body may lack any symmetry. With the platform's rate w along
e_y sin theta + e_z cos theta in the body's axes, the body's moments give the Lagrangian

    w^2 (I_y sin^2 theta + 2 I_yz sin theta cos theta + I_z cos^2 theta) / 2
    + w theta' (I_xy sin theta + I_xz cos theta).

The last line is the derivative of a function of theta, like the terms with pivot_x: I_xy and I_xz
have no effect. I_yz does not vanish, but an angle phi = theta + tilt, measured in the principal
axes of the moments about y and z, removes it: with a = (I_y - I_z) w^2 / 2 and d = I_yz w^2 / 2,

    tan(2 tilt) = 2 d / a,  a' = +-(a^2 + 4 d^2)^(1/2) with the sign of a,
    b' = b cos(tilt) + c sin(tilt),  c' = c cos(tilt) - b sin(tilt),

and V(theta) = -a' sin^2 phi - b' sin phi - c' cos phi + (a' - a)/2: three terms again, and every
closed form holds for phi."""

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
from plumbob.analytic.parameters import ParameterError, check_fields, finite, positive
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion


@dataclass(frozen=True)
class Body:
    """A rigid body hung on a horizontal axis: mass [kg], distance of its centre of mass from the
    axis [m], and moments of inertia about the pivot [kg m^2]; inertia_yz, an element of the inertia
    tensor, is minus the integral of y z over the mass; moment_roundings, the units in the last
    place by which the moments are uncertain. Raises ParameterError."""

    mass: float
    com_distance: float
    inertia_x: float
    inertia_y: float
    inertia_z: float
    inertia_yz: float = 0.0
    moment_roundings: float = 1.0

    def __post_init__(self) -> None:
        check_fields(self, ("mass", "com_distance", "inertia_x", "inertia_y", "inertia_z"))
        least = self.mass * self.com_distance**2
        if min(self.inertia_x, self.inertia_y) < least * (1 - 1e-12):
            name = "inertia_x" if self.inertia_x < least else "inertia_y"
            wanted = f"at least mass com_distance^2 = {least:.6g}"
            raise ParameterError(name, getattr(self, name), wanted)
        central_x = self.inertia_x - least
        central_y = self.inertia_y - least
        central = sorted((central_x, central_y, self.inertia_z))
        if central[2] > (central[0] + central[1]) * (1 + 1e-12):
            raise ParameterError(
                "inertia_x, inertia_y, inertia_z",
                (self.inertia_x, self.inertia_y, self.inertia_z),
                "possible: about the centre of mass none may exceed the sum of the other two",
            )
        # the two principal moments across x may differ by the third at most
        half = math.sqrt(
            max(0.0, (central_x / 2) ** 2 - ((central_y - self.inertia_z) / 2) ** 2)
        )
        if abs(self.inertia_yz) > half * (1 + 1e-12):
            wanted = (
                f"at most {half:.6g} in magnitude, or one principal moment of inertia exceeds "
            )
            raise ParameterError(
                "inertia_yz", self.inertia_yz, wanted + "the sum of the others"
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
    along = 0.3 * mass * height**2 * tan2
    # The relative change of tan^2 is 2 apex_angle/sin(apex_angle) times that of the angle; one of
    # the two terms of inertia_x is tan^2.
    blunt = 2 * apex_angle / math.sin(apex_angle) * tan2 / (4 + tan2)
    return Body(mass, 0.75 * height, across, across, along, moment_roundings=max(1.0, blunt))


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
    """A body on an axis at (pivot_x, pivot_y, pivot_z) [m] of a platform that turns at
    platform_rate [rad/s], under gravity [m/s^2], started at theta [rad] with theta_dot [rad/s], or
    with `excess` [J] above the highest barrier in the direction of theta_dot; pivot_x and pivot_z
    have no effect on theta. Raises ParameterError.

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
    pivot_z: float = 0.0

    def __post_init__(self) -> None:
        check_fields(self, (), ("gravity",), ("body", "excess"))
        if self.excess is not None:
            finite("excess", self.excess)
            _ = self.motion

    @cached_property
    def _terms(self) -> tuple[TrigonometricPotential, Quad, Quad]:
        """The three-term potential in phi = theta + tilt, the tilt, and what it lacks of V."""
        body = self.body
        rate2 = quad(self.platform_rate) ** 2
        arm = quad(body.mass) * body.com_distance
        a = (quad(body.inertia_y) - quad(body.inertia_z)) * rate2 / 2
        b = arm * self.pivot_y * rate2
        c = arm * self.gravity
        if body.inertia_yz == 0.0 or self.platform_rate == 0.0:
            return TrigonometricPotential(a, b, c), quad(0.0), quad(0.0)
        twice_d = quad(body.inertia_yz) * rate2
        sign = -1.0 if a < 0 else 1.0
        turned = sign * np.sqrt(a * a + twice_d * twice_d)
        tilt = np.arctan2(sign * twice_d, sign * a) / 2
        sine = np.sin(tilt)
        cosine = np.cos(tilt)
        v = TrigonometricPotential(turned, b * cosine + c * sine, c * cosine - b * sine)
        return v, tilt, (turned - a) / 2

    @property
    def potential(self) -> TrigonometricPotential:
        """V of H = p^2/(2 I_x) + V, the Legendre transform of Sudakov 2015, eq. 7, in 34 digits, as
        a function of theta + tilt and less `potential_offset`.

        a = (I_y - I_z) omega^2 / 2: the source's I_x for I_y holds for a symmetric body alone.
        """
        return self._terms[0]

    @property
    def tilt(self) -> float:
        """Angle [rad] to add to theta where the body has a product of inertia: between its own y
        and z axes and the principal ones, at most pi/4 in magnitude (module docstring)."""
        return float(double(self._terms[1]))

    @property
    def potential_offset(self) -> float:
        """V(theta) less `potential` of theta + tilt [J], a constant."""
        return float(double(self._terms[2]))

    @property
    def printed_potential(self) -> TrigonometricPotential:
        """V as printed in Sudakov 2015, eq. 9, which has no product of inertia: the centrifugal
        terms with the wrong sign."""
        v = replace(self, body=replace(self.body, inertia_yz=0.0), excess=None).potential
        return TrigonometricPotential(-v.a, -v.b, v.c)

    @cached_property
    def motion(self) -> PendulumMotion:
        """The exact motion of theta + tilt."""
        return PendulumMotion(
            self.potential,
            self.body.inertia_x,
            self.theta + self.tilt,
            self.theta_dot,
            self.excess,
            cancelled=self._cancelled * self.body.moment_roundings,
            inertia_roundings=self.body.moment_roundings,
        )

    @property
    def _cancelled(self) -> float:
        """Sum of I_y and I_z over their difference: a rounding of either is so many times one of
        a."""
        body = self.body
        terms = body.inertia_y + body.inertia_z
        apart = math.hypot(body.inertia_y - body.inertia_z, 2.0 * body.inertia_yz)
        return max(terms / apart, 1.0) if apart else 1.0

    @property
    def reference(self) -> PendulumMotion:
        """The exact motion of theta."""
        return replace(self.motion, tilt=self.tilt) if self.tilt else self.motion

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
        angle = np.array(self.motion.theta)
        speed = float(self.motion.momentum(angle)) / self.body.inertia_x
        return replace(self, theta_dot=speed, excess=None)

    @property
    def equilibria(self) -> tuple[Equilibrium, ...]:
        """Relative equilibria in (-pi, pi], ascending."""
        return tuple(
            sorted(
                map(self._equilibrium, critical_points(self.potential)), key=lambda e: e.theta
            )
        )

    def _equilibrium(self, theta: Quad) -> Equilibrium:
        potential, tilt, lacking = self._terms
        stiffness = abs(float(double(potential.curvature(theta))))
        sort = kind(potential, theta)
        rate = 0.0 if sort == "degenerate" else math.sqrt(stiffness / self.body.inertia_x)
        value = float(double(potential.value(theta) + lacking))
        angle = double(theta - tilt)
        angle -= 2 * math.pi * math.ceil(angle / (2 * math.pi) - 0.5)
        return Equilibrium(float(angle), value, sort, rate)

    @property
    def printed_barrier(self) -> tuple[float, float]:
        """Largest printed potential [J], which the source reads off Figs. 2a and 3a, and its angle
        [rad]."""
        v = self.printed_potential
        points = critical_points(v)
        if not points.size:
            return float(double(v.value(quad(0.0)))), 0.0
        values = double(v.value(points))
        return float(values.max()), float(double(points[values.argmax()]))

    @property
    def pitchfork_rate(self) -> float:
        """Platform rate [rad/s] at which hanging down stops being stable when pivot_y = 0 and
        inertia_yz = 0; infinite where it never does."""
        spread = self.body.inertia_y - self.body.inertia_z
        weight = self.body.mass * self.body.com_distance * self.gravity
        return math.sqrt(weight / spread) if spread > 0.0 else math.inf

    @property
    def saddle_node_rate(self) -> float:
        """Platform rate [rad/s] above which there are four equilibria and not two: V' and V'' are
        zero together where (2 a)^(2/3) = b^(2/3) + c^(2/3), an astroid; at pivot_y = 0 a pitchfork.
        Infinite where there are never four, NaN with a product of inertia."""
        if self.body.inertia_yz:
            return math.nan
        arm = self.body.mass * self.body.com_distance
        spread = abs(self.body.inertia_y - self.body.inertia_z) ** (2 / 3)
        gap = spread - abs(arm * self.pivot_y) ** (2 / 3)
        return math.sqrt(arm * self.gravity / gap**1.5) if gap > 0.0 else math.inf
