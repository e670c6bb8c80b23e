"""Motion in V = -a sin^2 - b sin - c cos in closed form: every regime is one amplitude equation.

On the circle n = (cos phi, sin phi, 1), phi measured from a saddle of V, the kinetic energy is a
quadratic form Q(n) = E n3^2 + (n3 - n1)(l.n), with E the energy above the saddle. A Moebius map of
tan(phi/2), chosen by an eigenvector of Q, turns Q into g4 z^4 + g2 z^2 + g0, and z(t) is

    rotation     z = rho sn/cn
    one_pair     z = zmax cn          (libration between the only two turning points)
    two_pairs    z = +-r1 dn          (libration in one well of two)
    between      z = z0 exp(A tau)    (from one of two equally high saddles to the other)

of A tau with 1 - m = B^2/A^2 and tau = t/s: equivalent to a simple pendulum. Sudakov 2015 gives the
integral (16) and says that no special function inverts it; these do. E enters directly, never as a
difference, so that the period keeps its digits next to a separatrix.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.elliptic.jacobi_functions import jacobi, time_of_point
from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import PI, Quad, choose, double, quad, split
from plumbob.analytic.reference import Array

_ONE = quad(1.0)
_BACK = 1e-14  # of a half turn: how far round-off may put an angle before the start
# Two parts of 2 pi: n times the first, 201/32, is exact.
TURN = (201 / 32, double(2 * PI - 201 / 32))


@dataclass(frozen=True)
class EllipticMotion:
    """The closed form for one start, or for an array of starts, in 34-digit constants.

    All fields but the potential have the shape of the start; see `reduction.solve`.
    """

    potential: TrigonometricPotential  # [J], 34 digits
    inertia: Quad  # [kg m^2]
    theta0: Quad  # [rad]
    kinetic: Quad  # [J], energy of the start
    forward: Any  # bool: theta_dot >= 0 at the start
    excess: Quad  # E [J], energy above the saddle that is nearest to it
    rest: Any  # bool
    rotation: Any  # bool; a separatrix over the highest barrier counts as one of infinite period
    two_pairs: Any  # bool
    between: Any  # bool
    across: Quad  # sine of half the angle from q, where z is 0, to p, where it is infinite
    along: Quad  # its cosine
    origin: Quad  # theta [rad] of q
    scale: Quad  # rho, zmax, +-r1 or z0
    modulus: Quad  # m
    a: Quad  # A
    b: Quad  # B
    s: Quad  # [s sqrt(J)], time scale
    half: Any  # tau in which chi advances by pi, in double; infinite on a separatrix
    tau0: Any  # amplitude time of the start, in double
    period: Quad  # [s]: of one turn, or of a full libration; infinite on a separatrix

    @property
    def sense(self) -> Any:
        """-1.0 for a backward rotation, whose tau falls with time, else 1.0."""
        return choose(self.rotation & np.logical_not(self.forward), -1.0, 1.0)

    def state(self, times: Array) -> tuple[Array, Array]:
        """theta [rad] and theta_dot [rad/s] at `times` [s] after the start, which broadcast with
        the shape of the starts."""
        period = double(self.period)
        finite = np.isfinite(period)
        high, low = split(choose(finite, self.period, _ONE), 20)
        turns = choose(finite, np.rint(times / period), 0.0)
        tau = self.tau0 + (times - turns * high - turns * low) * (self.sense / double(self.s))
        around = self.sense * turns
        if np.any(self.rotation):
            half = choose(finite, self.half, 1.0)
            halves = choose(self.rotation & finite, np.rint(tau / half), 0.0)
            tau, around = tau - halves * half, around + halves
        angle, rate = self._angle(tau)
        theta = 2 * angle + double(self.origin)
        for part in reversed(TURN):
            theta = theta + choose(self.rotation, part, 0.0) * around
        still = np.zeros(theta.shape)
        return (
            choose(self.rest, double(self.theta0) + still, theta),
            choose(self.rest, still, self.sense * rate),
        )

    def _angle(self, tau: Array) -> tuple[Array, Array]:
        """phi/2 from the direction of q on, and |dphi/dt|; |chi| <= pi/2 when rotating."""
        scale = double(self.scale)
        # where x is dn less the 1 in the constants below
        narrow = self.two_pairs & (double(self.modulus) < 0.5)
        x, y, slope = self._quotient(tau, narrow)
        across, along = double(self.across), double(self.along)
        sideways, ahead = (scale * across) * x, (scale * along) * x + y
        if np.any(narrow):
            sideways = sideways + choose(narrow, scale * across, 0.0)
            ahead = ahead + choose(narrow, double(self.scale * self.along + _ONE), 0.0)
        unit = sideways * sideways + ahead * ahead
        rate = slope / unit * (2 * across * scale * double(self.a) / double(self.s))
        return np.arctan2(sideways, ahead), rate

    def _quotient(self, tau: Array, narrow: Any) -> tuple[Array, Array, Array]:
        """x and y, of which z is scale x / y, and y dx/dchi - x dy/dchi, with dn for dchi/dt."""
        a, modulus = double(self.a), double(self.modulus)
        sn, cn, dn = jacobi(tau, a, double(self.b))
        x = choose(self.rotation, sn, choose(self.two_pairs, dn, cn))
        x = choose(narrow, -modulus * sn * sn / (1.0 + dn), x)
        y = choose(self.rotation, cn, choose(narrow, 0.0, 1.0))
        slope = choose(self.two_pairs, -modulus * cn, -dn) * sn
        slope = choose(self.rotation, dn, slope)
        if np.any(self.between):
            growth = np.clip(choose(self.between, a * tau, 0.0), -300.0, 300.0)
            x = choose(self.between, np.exp(growth), x)
            slope = choose(self.between, x, slope)
        return x, y, slope

    def time_at(self, theta: Array) -> Array:
        """Time [s] after the start at which a single motion first reaches `theta` [rad], shape
        (n,); NaN where it never does."""
        if self.rest:
            return np.where(double(quad(theta) - self.theta0) == 0.0, 0.0, np.nan)
        with np.errstate(all="ignore"):
            target = _Target.of(self, theta)
            if self.between:
                wait = self._wait_between(target)
            elif self.rotation:
                wait = self._wait_rotating(target)
            else:
                wait = self._wait_librating(target)
            scale = self.half if np.isfinite(self.half) else 1.0 / abs(double(self.a))
            reached = np.isfinite(wait) & (wait >= -_BACK * scale)
            return np.where(reached, double(self.s) * np.maximum(wait, 0.0), np.nan)

    def _wait_between(self, target: _Target) -> Array:
        """Amplitude time to a target from one saddle to the other."""
        wait = np.log(double(target.x / (target.y * self.scale))) / double(self.a)
        return np.where(target.halves == 0.0, wait, np.nan)

    def _wait_rotating(self, target: _Target) -> Array:
        """Amplitude time to a target of a rotation, negative where it lies behind the start."""
        x, y = target.x / self.scale, target.y
        length = np.sqrt(x**2 + y**2) * choose(y < 0, -1.0, 1.0)
        wait = time_of_point(x / length, y / length, self.a, self.b)
        half_turns = np.where(target.halves == 0.0, 0.0, target.halves * self.half)
        return np.asarray(self.sense * (half_turns + wait - self.tau0))

    def _wait_librating(self, target: _Target) -> Array:
        """Amplitude time to a target of a libration; NaN where it is out of reach."""
        z = target.x / (target.y * self.scale)
        square = z * z
        slack = abs(2 * z / (self.across * self.scale * target.y * target.y)) * target.size
        if self.two_pairs:
            square = (square - (1 - self.modulus)) / self.modulus
            slack = slack / self.modulus
        # An angle is within reach when one that rounds to it is.
        inside = abs(square - quad(0.5)) <= 0.5 + 1e-15 + slack * ULP
        inside &= (target.halves == 0.0) & ((z > 0) | (not self.two_pairs))
        square = np.minimum(np.maximum(square, quad(0.0)), quad(1.0))
        tau = time_of_point(np.sqrt(1 - square), np.sqrt(square), self.a, self.b)
        if not self.two_pairs:
            tau = np.where(z < 0, self.half - tau, tau)
        cycle = self.half if self.two_pairs else 2 * self.half
        waits = np.stack([np.mod(t - self.tau0, cycle) for t in (tau, -tau)])
        waits = np.where(waits > cycle * (1 - _BACK), 0.0, waits)
        return np.where(inside, waits.min(axis=0), np.nan)


@dataclass(frozen=True)
class _Target:
    """Angles to reach, shape (n,), as z = x/y in 34 digits, the half turns of phi/2 from the
    direction of q to them, and 1 + |theta|."""

    x: Quad
    y: Quad
    halves: Array
    size: Quad

    @classmethod
    def of(cls, motion: EllipticMotion, theta: Array) -> _Target:
        half_angle = (quad(theta) - motion.origin) / 2
        sine, cosine = np.sin(half_angle), np.cos(half_angle)
        x, y = sine / motion.across, cosine - motion.along * sine / motion.across
        side = choose(y < 0, -1.0, 1.0)
        near = np.arctan2(double(sine * side), double(cosine * side))
        halves = np.rint((double(half_angle) - near) / np.pi)
        return cls(x, y, halves, 1 + abs(quad(theta)))
