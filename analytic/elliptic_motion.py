"""Motion in V = -a sin^2 - b sin - c cos in closed form: every regime is one amplitude equation.

On the circle n = (cos phi, sin phi, 1), phi measured from a saddle of V, the kinetic energy is a
quadratic form Q(n) = E n3^2 + (n3 - n1)(l.n), with E the energy above the saddle. A Moebius map of
tan(phi/2), chosen by an eigenvector of Q, turns Q into g4 z^4 + g2 z^2 + g0, and z(t) is

    rotation     z = rho tan chi
    one_pair     z = zmax cos chi               (libration between the only two turning points)
    two_pairs    z = +-sqrt(r1^2 cos^2 chi + r2^2 sin^2 chi)      (libration in one well of two)

with dchi/dt = sqrt(A^2 cos^2 chi + B^2 sin^2 chi) / s: a simple pendulum in disguise. Sudakov 2015
has the integral (16) and says that no special function inverts it; this one does. E enters as it
is, never as a difference, so that the period keeps its digits next to a separatrix.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from analytic.elliptic_amplitude import amplitude, half_turn, time_of_point
from analytic.quad import Quad, double, quad, split
from analytic.reference import Array
from analytic.trigonometric_potential import TrigonometricPotential


@dataclass(frozen=True)
class EllipticMotion:
    """The closed form for one start, or for an array of starts, in 34-digit constants.

    All fields but the potential have the shape of the start; see `elliptic_reduction.solve`.
    """

    potential: TrigonometricPotential  # [J], 34 digits
    inertia: Quad  # [kg m^2]
    theta0: Quad  # [rad]
    forward: Any  # bool: theta_dot >= 0 at the start
    saddle: Quad  # [rad], origin of phi
    excess: Quad  # E [J], energy above that saddle
    rest: Any  # bool
    rotation: Any  # bool; a separatrix over the highest barrier counts as one of infinite period
    two_pairs: Any  # bool
    x_p: Quad  # (sin, cos)(phi/2) of the map's fixed points p and q, with z infinite at p, 0 at q
    y_p: Quad
    x_q: Quad
    y_q: Quad
    scale: Quad  # rho, zmax or +-r1
    inner: Quad  # +-r2 for two_pairs
    a: Quad  # A
    b: Quad  # B
    s: Quad  # [s sqrt(J)], time scale
    tau0: Array  # amplitude time of the start, in double
    period: Quad  # [s]: of one turn, or of a full libration; infinite on a separatrix

    def state(self, times: Array, *, reduced: bool = False) -> tuple[Array, Array]:
        """theta [rad] and theta_dot [rad/s] at `times` [s] after the start, which broadcast with
        the shape of the starts; `reduced` promises |t| of a few periods."""
        turns = np.zeros(())
        if not reduced:
            finite = np.isfinite(double(self.period))
            parts = split(np.where(finite, self.period, quad(1.0)), 20, 3)
            turns = np.where(finite, np.rint(times / sum(parts)), 0.0)
            for part in parts:
                times = times - turns * part
        a, b, s = double(self.a), double(self.b), double(self.s)
        sense = np.where(self.rotation & np.logical_not(self.forward), -1.0, 1.0)
        chi = amplitude(self.tau0 + sense * times / s, a, b)
        angle, rate = self._angle(chi)
        start, _ = self._angle(amplitude(self.tau0, a, b))
        theta = double(self.theta0) + 2 * (angle - start)
        theta = theta + np.where(self.rotation, sense * turns * 2 * np.pi, 0.0)
        moving = np.where(self.rotation, sense, 1.0) * rate
        return np.where(self.rest, double(self.theta0), theta), np.where(self.rest, 0.0, moving)

    def time_at(self, theta: Array) -> Array:
        """Time [s] after the start at which a single motion first reaches `theta` [rad], shape
        (n,); NaN where it never does."""
        a, b, s = double(self.a), double(self.b), double(self.s)
        start = self._angle(amplitude(self.tau0, a, b))[0]
        half = quad(start) + (quad(theta) - self.theta0) / 2  # from the direction of q
        sine, cosine = np.sin(half), np.cos(half)
        across = self.x_p * self.y_q - self.y_p * self.x_q
        along = self.x_p * self.x_q + self.y_p * self.y_q
        x, y = sine / across, cosine - along * sine / across
        turn = double(half_turn(self.a, self.b))
        with np.errstate(all="ignore"):
            if bool(self.rotation):
                turns = np.rint(double(half) / np.pi)
                length = np.sqrt((x / self.scale) ** 2 + y**2) * np.where(y < 0, -1.0, 1.0)
                point = (x / self.scale / length, y / length)
                # The sheet of chi is the one on which the angle was measured.
                chi = np.arctan2(double(point[0]), double(point[1]))
                turns = np.rint((double(half) - self._angle(chi)[0]) / np.pi)
                tau = turns * turn + time_of_point(*point, self.a, self.b)
                sense = 1.0 if bool(self.forward) else -1.0
                after = s * sense * (tau - self.tau0)
                return np.where(after >= -1e-14 * turn * s, np.maximum(after, 0.0), np.nan)
            z = x / y
            if bool(self.two_pairs):
                gap = self.scale**2 - self.inner**2
                square = (z * z - self.inner**2) / gap
                reached = double(z * self.scale) > 0.0
            else:
                square, reached = (z / self.scale) ** 2, np.isfinite(double(z))
            inside = reached & (double(square) >= -1e-15) & (double(square) <= 1 + 1e-15)
            square = np.minimum(np.maximum(square, quad(0.0)), quad(1.0))
            tau = time_of_point(np.sqrt(1 - square), np.sqrt(square), self.a, self.b)
            if not bool(self.two_pairs):
                tau = np.where(double(z * self.scale) < 0.0, turn - tau, tau)
            whole = turn if bool(self.two_pairs) else 2 * turn
            waits = [np.mod(t - self.tau0, whole) for t in (tau, -tau)]
            return np.where(inside, s * np.minimum(*waits), np.nan)

    def _angle(self, chi: Array) -> tuple[Array, Array]:
        """phi/2 from the direction of q on, continuous in chi, and dphi/dt."""
        names = ("x_p", "y_p", "x_q", "y_q", "scale", "inner", "a", "b", "s")
        x_p, y_p, x_q, y_q, scale, inner, a, b, s = (double(getattr(self, n)) for n in names)
        sine, cosine = np.sin(chi), np.cos(chi)
        radius = np.sign(scale) * np.hypot(scale * cosine, inner * sine)
        x = np.where(self.rotation, scale * sine, np.where(self.two_pairs, radius, scale * cosine))
        y = np.where(self.rotation, cosine, 1.0)
        with np.errstate(all="ignore"):
            slope = np.where(
                self.rotation,
                scale,
                np.where(
                    self.two_pairs,
                    (inner**2 - scale**2) * sine * cosine / radius,
                    -scale * sine,
                ),
            )
        along, across = x_p * x_q + y_p * y_q, x_p * y_q - y_p * x_q
        relative = np.arctan2(x * across, x * along + y)
        # In a rotation the direction winds with chi; what is left of it does not.
        turns = np.where(self.rotation, np.rint((chi - relative) / np.pi), 0.0) * np.pi
        square = x * x + 2 * along * x * y + y * y
        speed = np.sqrt((a * cosine) ** 2 + (b * sine) ** 2) / s
        return relative + turns, 2 * across * slope * speed / square
