"""Equations of motion of a body on three Coulomb points with a prescribed slider.

Written for the body's point that the combined centre G = C + mu r is passing, with velocity p
(Chernousko 2020, eqs. 2-4 and 23 with the slider's force eliminated):

    dp/dt = sum F_i/(M + m) - mu w - omega k x (p + mu v)        (rate in body axes)
    (J + mu M r^2) d(omega)/dt = sum (CA_i - mu r) x F_i - mu M (r x w + 2 (r.v) omega)
    v_i = p + omega k x (CA_i - mu r)

p and omega vanish with the body's motion, so that they keep their digits near rest.
Plane vectors are complex numbers x + iy in body axes, so that k x a is ia.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import CORNERS, Capsule, normal_forces
from plumbob.analytic.systems.slider_path import Piece

Complex = npt.NDArray[np.complex128]


@dataclass(frozen=True)
class Mechanics:
    """A capsule's constants in the form that the equations use; `limits` f N_i are affine in r."""

    mass: float  # M + m [kg]
    mass_ratio: float
    reduced_mass: float  # mu M [kg]
    body_inertia: float  # J [kg m^2]
    supports: Complex  # [m], shape (3,)
    centre_limits: Array  # f N_i with Q at C [N], shape (3,)
    limit_slopes: Array  # change of f N_i with r [N/m], shape (2, 3)


@dataclass(frozen=True)
class Configuration:
    """Terms of the equations that the slider's place and motion determine, at n times."""

    position: Complex  # r [m], shape (n,)
    velocity: Complex  # v [m/s]
    acceleration: Complex  # w [m/s^2]
    limits: Array  # f N_i [N], shape (n, 3)
    arms: Complex  # CA_i - mu r [m], shape (n, 3)
    inertia: Array  # J + mu M r^2 [kg m^2]


def mechanics(capsule: Capsule) -> Mechanics:
    """Constants of `capsule`."""
    here, x, y = capsule.friction * normal_forces(capsule, CORNERS)
    return Mechanics(
        mass=capsule.body_mass + capsule.slider_mass,
        mass_ratio=capsule.mass_ratio,
        reduced_mass=capsule.mass_ratio * capsule.body_mass,
        body_inertia=capsule.inertia,
        supports=np.array([complex(*point) for point in capsule.supports]),
        centre_limits=here,
        limit_slopes=np.stack([x - here, y - here]),
    )


def cross(a: Complex, b: Complex) -> Array:
    """Vertical component of a x b."""
    return (a.conjugate() * b).imag


def configuration(body: Mechanics, piece: Piece, times: Array) -> Configuration:
    """The slider's part in the equations at local `times` [s], shape (n,), of `piece`."""
    places, velocities, accelerations = piece.kinematics(times)
    r, v, w = (
        np.ascontiguousarray(part).view(np.complex128)[:, 0]
        for part in (places, velocities, accelerations)
    )
    return Configuration(
        position=r,
        velocity=v,
        acceleration=w,
        limits=body.centre_limits + places @ body.limit_slopes,
        arms=body.supports - body.mass_ratio * r[:, None],
        inertia=body.body_inertia + body.reduced_mass * np.vecdot(places, places),
    )


def support_velocities(at: Configuration, point: Complex, omega: Array) -> Complex:
    """Velocities v_i of the supports in body axes [m/s], shape (n, 3), from p and omega, (n,)."""
    return point[:, None] + 1j * omega[:, None] * at.arms


def sliding_forces(at: Configuration, velocities: Complex) -> Complex:
    """Coulomb forces on sliding supports in body axes [N], shape (n, 3) (Chernousko 2020, eq. 1);
    none where a support is at rest."""
    speeds = np.abs(velocities)
    return -at.limits * velocities / np.where(speeds > 0.0, speeds, 1.0)


def sliding_rates(
    body: Mechanics,
    at: Configuration,
    state: Array,
    clock: tuple[float, Array] | None,
    jerk: Complex | None = None,
    derived: bool = True,
) -> tuple[Array, Array]:
    """Rates of (p_x, p_y, omega, t) while every support slides, shape (n, 4), and their derivatives
    by (p_x, p_y, omega), shape (n, 4, 3), or with a clock by all four, (n, 4, 4), those by t only
    as far as they become large where v_i -> 0; without `derived` an empty array instead.

    `jerk` dw/dt [m/s^3], shape (n,), matters in the derivatives only. With `clock` = (a, b_i) the
    rates are by sigma in place of time, d sigma = dt (a + sum b_i/|v_i|): v_i = 0, where a force is
    singular in time, is approached as sigma -> infinity, and smoothly.
    """
    now = Slide.of(body, at, state)
    rates = now.rates(body, at)
    if not derived:
        return (rates * now.pace(clock)[:, None] if clock else rates), np.empty(0)
    if clock is None:
        return rates, now.derivatives(body, at, None)

    drift = now.back * (-1j * body.mass_ratio * now.omega * at.velocity)[:, None]
    derivative, pace = now.derivatives(body, at, drift), now.pace(clock)
    if jerk is not None:
        _add_jerk(body, at, now.omega, jerk, derivative)
    derivative *= pace[:, None, None]
    rates *= pace[:, None]
    along = np.empty((len(state), 3, 4))  # of d|v_i| by p_x, p_y, omega and t
    along[..., 0], along[..., 1] = now.back.real, -now.back.imag
    along[..., 2], along[..., 3] = -now.turned.imag, drift.real
    weights = clock[1] / (now.speeds * now.speeds) * pace[:, None]
    derivative += rates[:, :, None] * np.matmul(weights[:, None, :], along)
    return rates, derivative


def rates_in_time(body: Mechanics, at: Configuration, state: Array) -> Array:
    """Rates of (p_x, p_y, omega, t) by time while every support slides, shape (n, 4)."""
    return Slide.of(body, at, state).rates(body, at)


@dataclass(frozen=True)
class Slide:
    """All supports sliding, at n times: p and omega, shape (n,), and of each v_i its size, shape
    (n, 3), and its direction e as `back` e* and `turned` e* (CA_i - mu r)."""

    point: Complex
    omega: Array
    speeds: Array
    back: Complex
    turned: Complex
    widening: Array  # d/dt of the moment of inertia [kg m^2/s], shape (n,)

    @classmethod
    def of(cls, body: Mechanics, at: Configuration, state: Array) -> Slide:
        """From the `state` (p_x, p_y, omega, ...), shape (n, 3 or more)."""
        point, omega = state[:, 0] + 1j * state[:, 1], state[:, 2]
        velocities = support_velocities(at, point, omega)
        speeds = np.abs(velocities)
        back = velocities.conjugate() / speeds
        widening = 2.0 * body.reduced_mass * (at.position.conjugate() * at.velocity).real
        return cls(point, omega, speeds, back, back * at.arms, widening)

    def pace(self, clock: tuple[float, Array]) -> Array:
        """dt/d(sigma) of the `clock`, shape (n,)."""
        return 1.0 / (clock[0] + (1.0 / self.speeds) @ clock[1])

    def rates(self, body: Mechanics, at: Configuration) -> Array:
        """Rates of (p_x, p_y, omega, t) by time, shape (n, 4)."""
        mu, w, omega = body.mass_ratio, at.acceleration, self.omega
        resistance = np.vecdot(self.back, at.limits) / body.mass
        push = -resistance - mu * w - 1j * omega * (self.point + mu * at.velocity)
        rates = np.empty((len(omega), 4))
        rates[:, 0], rates[:, 1] = push.real, push.imag
        moment = np.vecdot(at.limits, self.turned.imag)
        moment -= body.reduced_mass * cross(at.position, w) + self.widening * omega
        rates[:, 2] = moment / at.inertia
        rates[:, 3] = 1.0
        return rates

    def derivatives(self, body: Mechanics, at: Configuration, drift: Complex | None) -> Array:
        """Derivatives of the rates by (p_x, p_y, omega), shape (n, 4, 3), and with `drift` by t
        too, (n, 4, 4): each v_i changes across e with p_x, p_y, omega and t."""
        across = np.empty((*self.back.shape, 3 if drift is None else 4))
        across[..., 0], across[..., 1] = self.back.imag, self.back.real
        across[..., 2] = self.turned.real
        if drift is not None:
            across[..., 3] = drift.imag
        stiffness = (at.limits / self.speeds)[:, None, :]
        resisting = np.matmul(across[..., :3].transpose(0, 2, 1) * stiffness, across)
        derivative = np.zeros((len(self.omega), 4, across.shape[2]))
        derivative[:, :2] = resisting[:, :2] / -body.mass
        derivative[:, 2] = resisting[:, 2] / -at.inertia[:, None]
        derivative[:, 0, 1] += self.omega
        derivative[:, 1, 0] -= self.omega
        carried = self.point + body.mass_ratio * at.velocity
        derivative[:, 0, 2] += carried.imag
        derivative[:, 1, 2] -= carried.real
        derivative[:, 2, 2] -= self.widening / at.inertia
        return derivative


def _add_jerk(
    body: Mechanics, at: Configuration, omega: Array, jerk: Complex, derivative: Array
) -> None:
    """Add to the derivatives by t, in place, the part of the slider's `jerk` [m/s^3]."""
    r, v, w = at.position, at.velocity, at.acceleration
    pushed = -body.mass_ratio * (jerk + 1j * omega * w)
    derivative[:, 0, 3] += pushed.real
    derivative[:, 1, 3] += pushed.imag
    swung = (
        cross(r, jerk) + cross(v, w) + 2.0 * omega * (v.conjugate() * v + r.conjugate() * w).real
    )
    derivative[:, 2, 3] -= body.reduced_mass * swung / at.inertia
