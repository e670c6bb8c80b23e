"""Equations of motion of a body on three Coulomb points with a prescribed slider.

Written for the body's point that the combined centre G = C + mu r is passing, with velocity p
(Chernousko 2020, eqs. 2-4 and 23 with the slider's force eliminated):

    dp/dt = sum F_i/(M + m) + tilt - mu w - omega k x (p + mu v)        (rate in body axes)
    (J + mu M r^2) d(omega)/dt = sum (CA_i - mu r) x F_i - mu M (r x w + 2 (r.v) omega)
    v_i = p + omega k x (CA_i - mu r)

p and omega vanish with the body's motion, so that they keep their digits as it comes to rest.
Plane vectors are complex numbers x + iy in body axes, so that k x a is ia.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule, normal_forces
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
    tilt: complex  # in-plane gravity in ground axes [m/s^2]


@dataclass(frozen=True)
class Configuration:
    """What the slider's place and motion fix at n times."""

    position: Complex  # r [m], shape (n,)
    velocity: Complex  # v [m/s]
    acceleration: Complex  # w [m/s^2]
    limits: Array  # f N_i [N], shape (n, 3)
    arms: Complex  # CA_i - mu r [m], shape (n, 3)
    inertia: Array  # J + mu M r^2 [kg m^2]


def mechanics(capsule: Capsule, tilt: tuple[float, float] = (0.0, 0.0)) -> Mechanics:
    """Constants of `capsule` on ground whose slope pulls with `tilt` [m/s^2] along ground axes."""
    here, x, y = capsule.friction * normal_forces(
        capsule, np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    )
    return Mechanics(
        mass=capsule.body_mass + capsule.slider_mass,
        mass_ratio=capsule.mass_ratio,
        reduced_mass=capsule.mass_ratio * capsule.body_mass,
        body_inertia=capsule.inertia,
        supports=np.array([complex(*point) for point in capsule.supports]),
        centre_limits=here,
        limit_slopes=np.stack([x - here, y - here]),
        tilt=complex(*tilt),
    )


def cross(a: Complex, b: Complex) -> Array:
    """Vertical component of a x b."""
    return np.asarray((a.conjugate() * b).imag)


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
        inertia=body.body_inertia + body.reduced_mass * (places * places).sum(axis=1),
    )


def support_velocities(at: Configuration, point: Complex, omega: Array) -> Complex:
    """Velocities v_i of the supports in body axes [m/s], shape (n, 3), from p and omega, (n,)."""
    return np.asarray(point[:, None] + 1j * omega[:, None] * at.arms)


def sliding_forces(at: Configuration, velocities: Complex) -> Complex:
    """Coulomb forces on sliding supports in body axes [N], shape (n, 3) (Chernousko 2020, eq. 1);
    none where a support is at rest."""
    speeds = np.abs(velocities)
    return np.asarray(-at.limits * velocities / np.where(speeds > 0.0, speeds, 1.0))


def sliding_rates(
    body: Mechanics,
    at: Configuration,
    state: Array,
    heading: Array,
    clock: tuple[float, Array] | None,
    jerk: Complex | None = None,
) -> tuple[Array, Array]:
    """Rates of (p_x, p_y, omega, t) while every support slides, shape (n, 4), and their derivatives
    by (p_x, p_y, omega), shape (n, 4, 3), or with a clock by all four, (n, 4, 4); by t what
    v_i -> 0 makes large.

    `heading` psi [rad] matters on tilted ground only; `jerk` dw/dt [m/s^3], shape (n,), only in the
    derivatives. With `clock` = (a, b_i) the rates are not by
    time but by sigma, d sigma = dt (a + sum b_i/|v_i|): the approach to v_i = 0, where a force is
    singular in time, takes for ever in sigma and is smooth.
    """
    point, omega = state[:, 0] + 1j * state[:, 1], state[:, 2]
    velocities = support_velocities(at, point, omega)
    speeds = np.abs(velocities)
    e = velocities / speeds
    forces = -at.limits * e
    mu, r, v, w = body.mass_ratio, at.position, at.velocity, at.acceleration
    push = forces.sum(axis=1) / body.mass - mu * w - 1j * omega * (point + mu * v)
    if body.tilt:
        push += body.tilt * np.exp(-1j * heading)
    widening = 2.0 * body.reduced_mass * (r.conjugate() * v).real
    rates = np.empty((len(state), 4))
    rates[:, 0], rates[:, 1] = push.real, push.imag
    rates[:, 2] = cross(at.arms, forces).sum(axis=1) - body.reduced_mass * cross(r, w)
    rates[:, 2] = (rates[:, 2] - widening * omega) / at.inertia
    rates[:, 3] = 1.0

    # How each v_i changes with p_x, p_y, omega and t: across e and, for the clock, along it.
    count = len(state)
    turned = e.conjugate() * at.arms
    across = np.empty((count, 3, 4 if clock else 3))
    across[..., 0], across[..., 1], across[..., 2] = -e.imag, e.real, turned.real
    if clock:
        drift = e.conjugate() * (-1j * mu * omega * v)[:, None]
        across[..., 3] = drift.imag
    stiffness = (at.limits / speeds)[:, None, :]
    resisting = np.matmul(across[..., :3].transpose(0, 2, 1) * stiffness, across)
    derivative = np.zeros((count, 4, across.shape[2]))
    derivative[:, :2] = resisting[:, :2] / -body.mass
    derivative[:, 2] = resisting[:, 2] / -at.inertia[:, None]
    derivative[:, 0, 1] += omega
    derivative[:, 1, 0] -= omega
    carried = point + mu * v
    derivative[:, 0, 2] += carried.imag
    derivative[:, 1, 2] -= carried.real
    derivative[:, 2, 2] -= widening / at.inertia
    if clock is None:
        return rates, derivative

    along = np.empty((count, 3, 4))
    along[..., 0], along[..., 1], along[..., 2], along[..., 3] = (
        e.real,
        e.imag,
        -turned.imag,
        drift.real,
    )
    weights = clock[1] / speeds
    pace = 1.0 / (clock[0] + weights.sum(axis=1))
    gradient = np.matmul((weights / speeds)[:, None, :], along)[:, 0] * (pace * pace)[:, None]
    if jerk is not None:
        pushed = -mu * (jerk + 1j * omega * w)
        derivative[:, 0, 3] += pushed.real
        derivative[:, 1, 3] += pushed.imag
        swung = (
            cross(r, jerk)
            + cross(v, w)
            + 2.0 * omega * (v.conjugate() * v + r.conjugate() * w).real
        )
        derivative[:, 2, 3] -= body.reduced_mass * swung / at.inertia
    derivative *= pace[:, None, None]
    derivative += rates[:, :, None] * gradient[:, None, :]
    return rates * pace[:, None], derivative
