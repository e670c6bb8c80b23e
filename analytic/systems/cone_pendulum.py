"""The cone pendulum on a rotating platform: mass properties, Lagrangian and both Hamiltonians.

Sudakov 2015. theta is the angle about the axis from hanging down; the platform turns at a constant
rate about the vertical. Eq. 9 of the source is not the Legendre transform of its Lagrangian (7): it
is T + U, which a prescribed rotation does not conserve. Both are implemented, under different
names.

The source adds that the body need not be symmetric. The platform's rate w is along e_y sin theta +
e_z cos theta in the body's axes. The body's moments then give the Lagrangian

    w^2 (I_y sin^2 theta + 2 I_yz sin theta cos theta + I_z cos^2 theta) / 2
    + w theta' (I_xy sin theta + I_xz cos theta).

The last line is the derivative of a function of theta, like the terms with pivot_x, so I_xy and
I_xz have no effect. I_yz has an effect. It vanishes for the angle phi = theta + tilt, measured in
the principal axes of the moments about y and z: with a = (I_y - I_z) w^2 / 2 and d = I_yz w^2 / 2,

    tan(2 tilt) = 2 d / a,  a' = +-(a^2 + 4 d^2)^(1/2) with the sign of a,
    b' = b cos(tilt) + c sin(tilt),  c' = c cos(tilt) - b sin(tilt),

and V(theta) = -a' sin^2 phi - b' sin phi - c' cos phi + (a' - a)/2. These are three terms again, so
every closed form holds for phi.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import (
    EquilibriumKind,
    TrigonometricPotential,
    critical_points,
    equilibrium_kind,
)
from plumbob.analytic.numerics.quad import Quad, double, quad
from plumbob.analytic.parameters import ParameterError, check_fields, finite, positive
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion


@dataclass(frozen=True)
class HungBody:
    """A rigid body hung on a horizontal axis: mass [kg], distance of its centre of mass from the
    axis [m], and moments of inertia about the pivot [kg m^2]. inertia_yz is an element of the
    inertia tensor: minus the integral of y z over the mass. moment_roundings is the uncertainty of
    the moments in units in the last place. Raises ParameterError."""

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
            need = f"at least mass com_distance^2 = {least:.6g}"
            raise ParameterError(name, getattr(self, name), need)
        central_x = self.inertia_x - least
        central_y = self.inertia_y - least
        central = sorted((central_x, central_y, self.inertia_z))
        if central[2] > (central[0] + central[1]) * (1 + 1e-12):
            raise ParameterError(
                "inertia_x, inertia_y, inertia_z",
                (self.inertia_x, self.inertia_y, self.inertia_z),
                "possible: about the centre of mass none may exceed the sum of the other two",
            )
        # The two principal moments across x differ by at most the third moment.
        square = (central_x / 2) ** 2 - ((central_y - self.inertia_z) / 2) ** 2
        largest = math.sqrt(max(0.0, square))
        if abs(self.inertia_yz) > largest * (1 + 1e-12):
            reason = "one principal moment of inertia exceeds the sum of the others"
            need = f"at most {largest:.6g} in magnitude, or {reason}"
            raise ParameterError("inertia_yz", self.inertia_yz, need)


def solid_cone(density: float, height: float, apex_angle: float) -> HungBody:
    """Returns a solid cone hung by its vertex (Sudakov 2015, eq. 1); density [kg/m^3], height [m],
    full apex angle [rad]. Raises ParameterError."""
    positive("density", density)
    positive("height", height)
    if not 0.0 < finite("apex_angle", apex_angle) < math.pi:
        raise ParameterError("apex_angle", apex_angle, "between 0 and pi radians")
    tan2 = math.tan(apex_angle / 2) ** 2
    mass = math.pi / 3 * density * height**3 * tan2
    across = 0.15 * mass * height**2 * (4 + tan2)
    along = 0.3 * mass * height**2 * tan2
    # The relative change of tan^2 is 2 apex_angle/sin(apex_angle) times the relative change of the
    # angle, and tan^2 is one of the two terms of inertia_x.
    condition = 2 * apex_angle / math.sin(apex_angle) * tan2 / (4 + tan2)
    return HungBody(
        mass=mass,
        com_distance=0.75 * height,
        inertia_x=across,
        inertia_y=across,
        inertia_z=along,
        moment_roundings=max(1.0, condition),
    )


@dataclass(frozen=True)
class Equilibrium:
    """An angle [rad] of relative rest, its potential [J], its kind, and the rate of small motions
    about it. The rate is that of the oscillation about a centre [rad/s], or of the departure from a
    saddle [1/s]."""

    theta: float
    potential: float
    kind: EquilibriumKind
    rate: float


class _TiltedPotential(NamedTuple):
    """A potential of theta: V(theta) = `potential`(theta + `tilt`) + `offset`."""

    potential: TrigonometricPotential
    tilt: Quad  # [rad]
    offset: Quad  # [J]


@dataclass(frozen=True)
class ConePendulum:
    """A body on an axis at (pivot_x, pivot_y, pivot_z) [m] of a platform that turns at
    platform_rate [rad/s], under gravity [m/s^2]. It starts at theta [rad] with theta_dot [rad/s],
    or with `excess` [J] above the highest barrier in the direction of theta_dot. pivot_x and
    pivot_z have no effect on theta. Raises ParameterError.

    >>> from math import radians
    >>> body = solid_cone(density=1000.0, height=0.3, apex_angle=radians(30.0))
    >>> pendulum = ConePendulum(body, 0.0, 0.0, 4.0, gravity=9.8, theta=0.5, theta_dot=0.0)
    >>> pendulum.motion.regime, round(pendulum.motion.period, 6)
    ('libration', 1.24948)
    """

    body: HungBody
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
            _ = self.motion  # raises ParameterError for an excess too small to reach theta

    @cached_property
    def _in_principal_axes(self) -> _TiltedPotential:
        """The potential V of theta, in axes in which the product of inertia I_yz is zero."""
        body = self.body
        rate2 = quad(self.platform_rate) ** 2
        arm = quad(body.mass) * body.com_distance
        a = (quad(body.inertia_y) - quad(body.inertia_z)) * rate2 / 2
        b = arm * self.pivot_y * rate2
        c = arm * self.gravity
        if body.inertia_yz == 0.0 or self.platform_rate == 0.0:
            return _TiltedPotential(TrigonometricPotential(a, b, c), quad(0.0), quad(0.0))
        twice_d = quad(body.inertia_yz) * rate2
        sign = -1.0 if a < 0 else 1.0
        principal_a = sign * np.sqrt(a * a + twice_d * twice_d)
        tilt = np.arctan2(sign * twice_d, sign * a) / 2
        sine = np.sin(tilt)
        cosine = np.cos(tilt)
        v = TrigonometricPotential(principal_a, b * cosine + c * sine, c * cosine - b * sine)
        return _TiltedPotential(v, tilt, (principal_a - a) / 2)

    @property
    def potential(self) -> TrigonometricPotential:
        """V of H = p^2/(2 I_x) + V, the Legendre transform of Sudakov 2015, eq. 7, with 34 digits,
        as a function of theta + tilt and without the constant `potential_offset`.

        a = (I_y - I_z) omega^2 / 2: the source has I_x in place of I_y, which holds only for a
        symmetric body.
        """
        return self._in_principal_axes.potential

    @property
    def tilt(self) -> float:
        """Angle [rad] from theta to the angle in the principal axes, at most pi/4 in magnitude; 0
        without a product of inertia (module docstring)."""
        return float(double(self._in_principal_axes.tilt))

    @property
    def potential_offset(self) -> float:
        """The constant V(theta) - `potential`(theta + tilt) [J]."""
        return float(double(self._in_principal_axes.offset))

    @property
    def printed_potential(self) -> TrigonometricPotential:
        """V as printed in Sudakov 2015, eq. 9, without a product of inertia: its centrifugal terms
        have the wrong sign."""
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
            cancelled=self._cancellation * self.body.moment_roundings,
            inertia_roundings=self.body.moment_roundings,
        )

    @property
    def _cancellation(self) -> float:
        """Sum of I_y and I_z over their difference: the factor by which a rounding of either is
        larger in a."""
        body = self.body
        total = body.inertia_y + body.inertia_z
        difference = math.hypot(body.inertia_y - body.inertia_z, 2.0 * body.inertia_yz)
        return max(total / difference, 1.0) if difference else 1.0

    @property
    def reference(self) -> PendulumMotion:
        """The exact motion with theta as the observed angle."""
        return replace(self.motion, tilt=self.tilt) if self.tilt else self.motion

    def printed_motion(self) -> PendulumMotion:
        """Returns the motion that the printed eqs. 9, 15 and 16 describe, with the same start. Only
        the paper's figures and the finding about them use it."""
        return PendulumMotion(
            self.printed_potential, self.body.inertia_x, self.theta, self.theta_dot
        )

    @property
    def started(self) -> ConePendulum:
        """This problem with theta_dot, rounded to double, in place of `excess`."""
        if self.excess is None:
            return self
        angle = np.array(self.motion.theta)
        speed = float(self.motion.momentum(angle)) / self.body.inertia_x
        return replace(self, theta_dot=speed, excess=None)

    @property
    def equilibria(self) -> tuple[Equilibrium, ...]:
        """Relative equilibria in (-pi, pi], ascending."""
        equilibria = [self._equilibrium(angle) for angle in critical_points(self.potential)]
        return tuple(sorted(equilibria, key=lambda equilibrium: equilibrium.theta))

    def _equilibrium(self, theta: Quad) -> Equilibrium:
        """Returns the equilibrium at the critical point `theta` [rad] of `potential`."""
        potential, tilt, offset = self._in_principal_axes
        stiffness = abs(float(double(potential.curvature(theta))))
        kind = equilibrium_kind(potential, theta)
        rate = 0.0 if kind == "degenerate" else math.sqrt(stiffness / self.body.inertia_x)
        value = float(double(potential.value(theta) + offset))
        angle = double(theta - tilt)
        angle -= 2 * math.pi * math.ceil(angle / (2 * math.pi) - 0.5)
        return Equilibrium(float(angle), value, kind, rate)

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
        """Platform rate [rad/s] at which hanging down becomes unstable if pivot_y = 0 and
        inertia_yz = 0; infinite if it never does."""
        spread = self.body.inertia_y - self.body.inertia_z
        weight = self.body.mass * self.body.com_distance * self.gravity
        return math.sqrt(weight / spread) if spread > 0.0 else math.inf

    @property
    def saddle_node_rate(self) -> float:
        """Platform rate [rad/s] above which there are four equilibria in place of two. There V' and
        V'' are zero together: (2 a)^(2/3) = b^(2/3) + c^(2/3), an astroid; at pivot_y = 0 it is a
        pitchfork. Infinite if there are never four; NaN with a product of inertia."""
        if self.body.inertia_yz:
            return math.nan
        arm = self.body.mass * self.body.com_distance
        spread = abs(self.body.inertia_y - self.body.inertia_z) ** (2 / 3)
        gap = spread - abs(arm * self.pivot_y) ** (2 / 3)
        return math.sqrt(arm * self.gravity / gap**1.5) if gap > 0.0 else math.inf
