"""The rotation of a free rigid body by Jacobi's functions, and its attitude.

The angular momentum l = I w in the body frame obeys l' = l x w (Euler). Let d_ij = |1/I_i - 1/I_j|
and call the axes c, m, o. Axis m has the middle moment. Axis c is the one, of the largest and the
smallest moment, that l goes round, so that kappa = d_cm l_c^2 - d_om l_o^2 >= 0 (zero on the
separatrix). Then

    l_c = +-C dn,  l_o = +-O cn,  l_m = +-M sn  of A tau, with the modulus 1 - B^2/A^2,
    alpha^2 = d_co l_c^2 + d_om l_m^2,  beta^2 = d_co l_o^2 + d_cm l_m^2,  A^2 = alpha^2 d_cm,
    B^2 = d_co kappa,  C^2 = alpha^2/d_co,  O^2 = beta^2/d_co,  M^2 = beta^2/d_cm

(Whittaker 1937, Analytical Dynamics, 69; rewritten without the difference of two large numbers).
The attitude takes l to the fixed L in two turns. The first is the shortest turn of l to the axis c,
on the side of l. The second is about that axis, by the angle phi with

    phi' = L/I_c +- (beta^2/L)/(1 + |l_c|/L),    + where c has the largest moment:

the turning rate of the shortest-turn frame, which has no singularity on the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.numerics.elliptic.jacobi_functions import half_turn, jacobi, time_of_point
from plumbob.analytic.numerics.elliptic.reciprocal_integral import ReciprocalIntegral
from plumbob.analytic.numerics.quad import PI, Quad, double, quad
from plumbob.analytic.reference import Array

ANGULAR_VELOCITY_NAMES = ("angular_velocity_x", "angular_velocity_y", "angular_velocity_z")
ATTITUDE = ("attitude_w", "attitude_x", "attitude_y", "attitude_z")


@dataclass(frozen=True)
class Rotation:
    """The rotation of a body with principal moments of `inertia` [kg m^2] and the angular velocity
    `rates` [rad/s] at time 0, in its own axes, which are the world's axes at that time. Both have
    34 digits and shape (3,)."""

    inertia: Quad
    rates: Quad

    @cached_property
    def momentum(self) -> Quad:
        """Angular momentum [kg m^2/s] at time 0, shape (3,)."""
        return self.inertia * self.rates

    @cached_property
    def magnitude(self) -> Quad:
        """Magnitude of the angular momentum [kg m^2/s]."""
        return np.sqrt((self.momentum * self.momentum).sum())

    @cached_property
    def constants(self) -> RotationConstants | None:
        """The constants of the closed form; None if the angular velocity is constant."""
        moments = self.inertia
        momentum = self.momentum
        torque = (moments - np.roll(moments, 1)) * momentum * np.roll(momentum, 1)
        return _constants(self) if torque.any() else None

    def state(self, times: Array) -> Array:
        """Returns angular velocity [rad/s] in the body's axes, three rows, and attitude, four rows,
        at `times` [s], shape (n,). The attitude is a unit quaternion from body to world,
        continuous, and starts at 1."""
        times = np.asarray(times, dtype=np.float64)
        if self.constants is None:
            return self._steady_state(times)
        momentum, angle = self.constants.at(times)
        rates = momentum / double(self.inertia)[:, None]
        return np.concatenate([rates, self._attitude(momentum, angle)])

    def _steady_state(self, times: Array) -> Array:
        """Returns the state of a body whose angular velocity is constant."""
        rates = double(self.rates)[:, None]
        speed = np.sqrt((self.rates * self.rates).sum())
        half = _reduced_angle(quad(times) * speed) / 2
        axis = rates / (double(speed) or 1.0)
        return np.concatenate([rates + 0.0 * half, np.cos(half)[None], axis * np.sin(half)])

    def _attitude(self, momentum: Array, angle: Array) -> Array:
        """Returns the attitude, shape (4, n), from the momentum in body axes, shape (3, n), and the
        angle phi [rad], shape (n,). It is the product of three turns: the shortest turn of l to the
        axis c, the turn by phi about that axis, and the inverse of the first turn at time 0."""
        assert self.constants is not None
        axis = np.zeros((3, 1))
        axis[self.constants.axes[0]] = self.constants.side
        first = _shortest_turn(double(self.momentum / self.magnitude), axis)
        first_inverse = first * np.array([[1.0], [-1.0], [-1.0], [-1.0]])
        about_axis = np.concatenate([np.cos(angle / 2)[None], axis * np.sin(angle / 2)])
        to_axis = _shortest_turn(momentum / double(self.magnitude), axis)
        return compose_quaternions(compose_quaternions(first_inverse, about_axis), to_axis)


@dataclass(frozen=True)
class RotationConstants:
    """The constants of the closed form in the module's docstring."""

    axes: tuple[int, int, int]  # c, m and o: 0, 1 or 2
    side: float  # sign of l_c
    signs: tuple[float, float]  # signs of l_m and l_o if sn and cn are positive
    amplitudes: Array  # [kg m^2/s] C, M and O, the largest |l_c|, |l_m| and |l_o|, shape (3,)
    a: Quad  # A [1/s]
    b: Quad  # B [1/s]
    half_turn: Quad  # half the period of the angular velocity [s]; infinite on the separatrix
    start_time: float  # tau at time 0 [s], at most a quarter turn
    base_rate: Quad  # [rad/s] phi' at the times when |l_c| is largest, that is C
    extra: Quad  # +-beta^2/L [rad/s]
    integral: ReciprocalIntegral

    def at(self, times: Array) -> tuple[Array, Array]:
        """Returns the angular momentum [kg m^2/s] in body axes, shape (3, n), and the angle phi
        [rad] since time 0, modulo 4 pi, shape (n,), at `times` [s], shape (n,)."""
        turns, reduced_time = self._reduced_time(times)
        sn, cn, dn = jacobi(reduced_time, double(self.a), double(self.b))
        momentum = np.empty((3, times.size))
        sign = np.where(turns % 2.0 == 0.0, 1.0, -1.0)
        parts = (self.side * dn, self.signs[0] * sign * sn, self.signs[1] * sign * cn)
        momentum[[*self.axes]] = self.amplitudes[:, None] * parts
        # phi grows at the base rate, and by an extra: in whole half turns, and in parts of a half
        # turn at the end and at the start.
        steady_angle = quad(times) * self.base_rate
        if np.isfinite(double(self.half_turn)):
            steady_angle = steady_angle + quad(turns) * self._extra_per_half_turn
        in_parts = self.integral.at(np.append(reduced_time, self.start_time), self.extra)
        return momentum, _reduced_angle(steady_angle) + (in_parts[:-1] - in_parts[-1])

    @cached_property
    def _extra_per_half_turn(self) -> Quad:
        """Part of phi in half a turn that the base rate leaves out [rad]."""
        return self.extra * self.integral.over_half_turn

    def _reduced_time(self, times: Array) -> tuple[Array, Array]:
        """Returns the number of half turns since tau = 0, and the remaining tau [s], at most a
        quarter turn."""
        tau = quad(times) + quad(self.start_time)
        if not np.isfinite(double(self.half_turn)):
            return np.zeros_like(times), double(tau)
        turns = np.rint(double(tau / self.half_turn))
        return turns, double(tau - quad(turns) * self.half_turn)


def _constants(body: Rotation) -> RotationConstants:
    """Returns the constants of a motion whose angular velocity changes."""
    squares = body.momentum * body.momentum
    high, middle, low = sorted(range(3), key=lambda i: -body.inertia[i])
    d_high = _inverse_difference(body, high, middle)
    d_low = _inverse_difference(body, low, middle)
    kappa = d_high * squares[high] - d_low * squares[low]
    axes = (high, middle, low) if kappa >= 0 else (low, middle, high)
    return _constants_for(body, axes, high, kappa)


def _inverse_difference(body: Rotation, i: int, j: int) -> Quad:
    """Returns d_ij = |1/I_i - 1/I_j| [1/(kg m^2)]."""
    inertia = body.inertia
    return abs(inertia[i] - inertia[j]) / (inertia[i] * inertia[j])


def _constants_for(
    body: Rotation, axes: tuple[int, int, int], high: int, kappa: Quad
) -> RotationConstants:
    """Returns the constants of the closed form (module docstring).

    `axes` are the axes c, m and o: the momentum goes round c, m has the middle moment of inertia,
    and o is the third axis. `high` is the axis of the largest moment of inertia.
    """
    c, middle, o = axes
    d_co = _inverse_difference(body, c, o)
    d_cm = _inverse_difference(body, c, middle)
    alpha, beta = _alpha_and_beta(body, axes)
    amplitudes = np.array([alpha, beta, beta]) / np.sqrt(np.array([d_co, d_cm, d_co]))
    a = alpha * np.sqrt(d_cm)
    b = np.sqrt(d_co * abs(kappa))
    c_part = amplitudes[0] / body.magnitude
    o_part = amplitudes[2] / body.magnitude
    extra = (1 if c == high else -1) * beta * beta / body.magnitude
    side, signs = _signs(body, axes, high)
    start_time = time_of_point(
        signs[0] * body.momentum[middle] / amplitudes[1],  # sn of A tau at time 0
        abs(body.momentum[o]) / amplitudes[2],  # cn of A tau at time 0
        a,
        b,
    )
    return RotationConstants(
        axes=axes,
        side=side,
        signs=signs,
        amplitudes=double(amplitudes),
        a=a,
        b=b,
        half_turn=half_turn(a, b),
        start_time=float(start_time),
        base_rate=body.magnitude / body.inertia[c] + extra / (1 + c_part),
        extra=extra,
        integral=ReciprocalIntegral(a, b, c_part, o_part**2 / (1 + c_part)),
    )


def _alpha_and_beta(body: Rotation, axes: tuple[int, int, int]) -> tuple[Quad, Quad]:
    """Returns alpha and beta of the module's docstring, with the `axes` c, m and o."""
    c, middle, o = axes
    squares = body.momentum * body.momentum
    d_co = _inverse_difference(body, c, o)
    d_cm = _inverse_difference(body, c, middle)
    d_om = _inverse_difference(body, o, middle)
    alpha = np.sqrt(d_co * squares[c] + d_om * squares[middle])
    beta = np.sqrt(d_co * squares[o] + d_cm * squares[middle])
    return alpha, beta


def _signs(
    body: Rotation, axes: tuple[int, int, int], high: int
) -> tuple[float, tuple[float, float]]:
    """Returns the sign of l_c, and the signs of l_m and l_o if sn and cn are positive, with the
    `axes` c, m and o; `high` is the axis of the largest moment."""
    c, middle, o = axes
    signs = [1.0 if component >= 0 else -1.0 for component in body.momentum]
    sign_m = signs[c] * signs[o]
    if (middle - high) % 3 == 1:
        sign_m = -sign_m
    return signs[c], (sign_m, signs[o])


def _reduced_angle(angle: Quad) -> Array:
    """Returns an angle [rad] less whole multiples of 4 pi, which do not change a quaternion."""
    turns = np.rint(double(angle / (4 * PI)))
    return np.asarray(double(angle - quad(turns) * (4 * PI)))


def _shortest_turn(direction: Array, axis: Array) -> Array:
    """Returns the quaternions, shape (4, n), of the shortest turn from unit vectors `direction`,
    shape (3, n) or (3,), to the `axis`, shape (3, 1). The turn is less than a half turn."""
    direction = direction.reshape(3, -1)
    axis = np.broadcast_to(axis, direction.shape)
    part = 1.0 + (direction * axis).sum(axis=0)
    quaternion = np.concatenate([part[None], np.cross(direction, axis, axis=0)])
    return np.asarray(quaternion / np.sqrt(2.0 * part))


def compose_quaternions(p: Array, q: Array) -> Array:
    """Returns Hamilton's product of quaternions, shape (4, n) each: the turn q, then the turn p."""
    return np.stack(np.broadcast_arrays(*quaternion_product([*p], [*q])))


def quaternion_product(p: Sequence[Any], q: Sequence[Any]) -> tuple[Any, Any, Any, Any]:
    """Returns Hamilton's product of two quaternions from their four parts, in any arithmetic."""
    (a, b, c, d), (w, x, y, z) = p, q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )
