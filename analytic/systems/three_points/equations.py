"""Equations of motion of a body on three Coulomb points with a prescribed slider.

Written for the body's point that the combined centre G = C + mu r is passing, with velocity p
(Chernousko 2020, eqs. 2-4 and 23 with the slider's force eliminated):

    dp/dt = sum F_i/(M + m) - mu w - omega k x (p + mu v)        (rate in body axes)
    (J + mu M r^2) d(omega)/dt = sum (CA_i - mu r) x F_i - mu M (r x w + 2 (r.v) omega)
    v_i = p + omega k x (CA_i - mu r)

    r, v, w     position, velocity and acceleration of the slider in the body
    omega       angular velocity of the body;  k  unit vector upwards
    A_i, v_i    place of support i, and its velocity;  F_i  friction on it
    mu          m/(M + m);  M, J  mass and moment of inertia of the body;  m  mass of the slider

p and omega are small when the body is nearly at rest, so they keep their digits there.
Plane vectors are complex numbers x + iy in body axes, so that k x a is ia.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule, load_gradient, normal_forces
from plumbob.analytic.systems.slider_path import Piece

ComplexForces = npt.NDArray[np.complex128]


@dataclass(frozen=True)
class Mechanics:
    """A capsule's constants in the form that the equations use. The friction limit f N_i of each
    support is an affine function of the slider's position r."""

    mass: float  # M + m [kg]
    mass_ratio: float
    reduced_mass: float  # mu M [kg]
    body_inertia: float  # J [kg m^2]
    supports: ComplexForces  # [m], shape (3,)
    centre_limits: Array  # f N_i with Q at C [N], shape (3,)
    limit_slopes: Array  # derivatives of f N_i by r [N/m], shape (2, 3)


@dataclass(frozen=True)
class Configuration:
    """Terms of the equations that depend only on the slider's position and motion, at n times."""

    position: ComplexForces  # r [m], shape (n,)
    velocity: ComplexForces  # v [m/s]
    acceleration: ComplexForces  # w [m/s^2]
    limits: Array  # f N_i [N], shape (n, 3)
    arms: ComplexForces  # CA_i - mu r [m], shape (n, 3)
    inertia: Array  # J + mu M r^2 [kg m^2]


def mechanics(capsule: Capsule) -> Mechanics:
    """Returns the constants of `capsule`."""
    forces_at_centre = normal_forces(capsule, np.zeros((1, 2)))[0]
    return Mechanics(
        mass=capsule.body_mass + capsule.slider_mass,
        mass_ratio=capsule.mass_ratio,
        reduced_mass=capsule.mass_ratio * capsule.body_mass,
        body_inertia=capsule.inertia,
        supports=np.array([complex(*point) for point in capsule.supports]),
        centre_limits=capsule.friction * forces_at_centre,
        limit_slopes=capsule.friction * load_gradient(capsule),
    )


def cross(a: ComplexForces, b: ComplexForces) -> Array:
    """Vertical component of a x b."""
    return (a.conjugate() * b).imag


def configuration(body: Mechanics, piece: Piece, times: Array) -> Configuration:
    """Returns the slider's terms in the equations at local `times` [s], shape (n,), of one `piece`
    of its path."""
    positions, velocities, accelerations = piece.kinematics(times)
    r, v, w = (
        np.ascontiguousarray(part).view(np.complex128)[:, 0]
        for part in (positions, velocities, accelerations)
    )
    return Configuration(
        position=r,
        velocity=v,
        acceleration=w,
        limits=body.centre_limits + positions @ body.limit_slopes,
        arms=body.supports - body.mass_ratio * r[:, None],
        inertia=body.body_inertia + body.reduced_mass * np.vecdot(positions, positions),
    )


def support_velocities(
    terms: Configuration, velocity: ComplexForces, omega: Array
) -> ComplexForces:
    """Returns the velocities v_i of the supports in body axes [m/s], shape (n, 3), from the
    `velocity` p [m/s] and the angular velocity `omega` [rad/s], both of shape (n,)."""
    return velocity[:, None] + 1j * omega[:, None] * terms.arms


Clock = tuple[float, Array]
"""The constants a and b_i, shape (3,), of the variable sigma (see `sliding_rates`)."""
TIME_CLOCK: Clock = (1.0, np.zeros(3))  # sigma is time
COMPLEX_STEP = 1e-200  # size of a complex step: its square underflows to 0


def sliding_rates(
    body: Mechanics,
    terms: Configuration,
    states: Array,
    clock: Clock = TIME_CLOCK,
    with_derivatives: bool = True,
) -> tuple[Array, Array]:
    """Returns the rates of (p_x, p_y, omega, t) while every support slides, shape (n, 4), and their
    derivatives by (p_x, p_y, omega), shape (n, 4, 3), from `states`, whose first three columns are
    these. If `with_derivatives` is False, the second array is empty.

    With `clock` = (a, b_i) the rates are by sigma, d sigma = dt (a + sum b_i/|v_i|). At v_i = 0 a
    force is singular in time. In sigma that point is approached smoothly, as sigma -> infinity.
    With such a clock the derivatives are by all four variables, shape (n, 4, 4); the derivatives by
    t hold only the terms that become large as v_i -> 0.

    Derivatives are by complex steps: the imaginary parts of the rates, which have no truncation
    error.
    """
    motion = states[:, :3].T
    if not with_derivatives:
        return np.asarray(_rates(body, terms, motion, 0.0, clock)), np.empty(0)
    variables = 3 if clock is TIME_CLOCK else 4
    steps = 1j * COMPLEX_STEP * np.eye(4, variables)[..., None]
    rates = _rates(body, terms, motion[:, None] + steps[:3], steps[3, ..., None], clock)
    return rates[0].real, np.moveaxis(rates.imag, 0, -1) / COMPLEX_STEP


def _rates(body: Mechanics, terms: Configuration, motion: Any, delay: Any, clock: Clock) -> Any:
    """Returns the rates, shape (..., n, 4), at `motion` = (p_x, p_y, omega), shape (3, ..., n).

    The supports' arms are those `delay` [s] later, at the slider's present velocity. Plane vectors
    have their components along the first axis.
    """
    velocity = motion[:2]
    omega = motion[2]
    centre_velocity = body.mass_ratio * terms.velocity
    centre_acceleration = body.mass_ratio * terms.acceleration
    arm_x = terms.arms.real - centre_velocity.real[:, None] * delay
    arm_y = terms.arms.imag - centre_velocity.imag[:, None] * delay
    turned_arms = np.stack([-arm_y, arm_x])
    slips = velocity[..., None] + omega[..., None] * turned_arms
    speeds = np.sqrt((slips * slips).sum(axis=0))
    resistances = terms.limits / speeds
    drag = (resistances * slips).sum(axis=-1) / body.mass
    moment = (resistances * (turned_arms * slips).sum(axis=0)).sum(axis=-1)
    slider_term = cross(terms.position, terms.acceleration)
    slider_term = slider_term + 2.0 * (terms.position.conjugate() * terms.velocity).real * omega
    rates = [
        omega * (velocity[1] + centre_velocity.imag) - centre_acceleration.real - drag[0],
        -omega * (velocity[0] + centre_velocity.real) - centre_acceleration.imag - drag[1],
        -(moment + body.reduced_mass * slider_term) / terms.inertia,
        np.ones_like(omega),
    ]
    sigma_rate = clock[0] + (clock[1] / speeds).sum(axis=-1)
    return np.stack(rates, axis=-1) / sigma_rate[..., None]
