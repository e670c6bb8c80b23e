"""Second order of the turn manoeuvre: the effect of friction along its leading-order motion.

Chernousko 2020 stops at eq. 32, the leading order; analytic/README.md derives the next one, with
the equation numbers used here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule, Point, normal_forces
from plumbob.analytic.systems.slider_path import fixed
from plumbob.analytic.systems.three_points.equations import Complex
from plumbob.analytic.systems.three_points.friction import Start, three_point_motion

CONVERGED = 1e-13  # of the quadrature, relative
PIECES = 1000  # of it, at most
SLOW = 1e-6  # its square is about the turn of the coasting body [rad], which the limit neglects


@dataclass(frozen=True)
class TurnPose:
    """Place of C [m] and heading [rad], from those of the start, or their rates [m/s] and [rad/s];
    as a coefficient of second order the pose over tau^2, of first order the rates over tau,
    [m/s^2] and [rad/s^2]."""

    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class TurnCorrection:
    """Coefficients of tau^2 in the pose when the slider stops (2 tau) and when the body rests, and
    of tau in the velocities when it stops and in the time from one to the other."""

    at_stop: TurnPose
    at_rest: TurnPose
    left_at_stop: TurnPose
    residual_time: float


def circle_inertia(capsule: Capsule, radius: float) -> float:
    """J + mu M a^2 [kg m^2], of body and slider about their combined centre, with the slider on
    the circle of `radius` a [m] about C (Chernousko 2020, eqs. 23, 25)."""
    return capsule.inertia + capsule.mass_ratio * capsule.body_mass * radius**2


def inertia_ratio(capsule: Capsule, radius: float) -> float:
    """mu_1 = mu M a^2/(J + mu M a^2) (Chernousko 2020, eq. 25)."""
    reduced = capsule.mass_ratio * capsule.body_mass
    return reduced * radius**2 / circle_inertia(capsule, radius)


def progress(phases: Array) -> Array:
    """Fraction of the slider's angle covered at times `phases` tau, shape (n,), up to 2 tau
    (Chernousko 2020, eqs. 26, 29)."""
    return 0.5 * np.square(phases) - np.square(np.maximum(phases - 1.0, 0.0))


def leading_friction(
    capsule: Capsule, radius: float, slider_angles: Array, sense: float
) -> tuple[Complex, Array]:
    """Friction along the leading-order motion (eq. 2): resultant in body axes [N], complex, and
    moment about the combined centre [N m], both of shape (n,).

    `slider_angles` phi [rad], shape (n,), from the body's x axis; `sense` is the sign of the
    slider's rate. Support i moves along -k x s_i, s_i = mu_1 CA_i + mu (1 - mu_1) r.
    """
    mu, mu_1 = capsule.mass_ratio, inertia_ratio(capsule, radius)
    r = radius * np.exp(1j * slider_angles)
    supports = np.array([complex(*point) for point in capsule.supports])
    slip = mu_1 * supports + mu * (1.0 - mu_1) * r[:, None]
    size = np.abs(slip)
    unit = sense * slip / np.where(size > 0.0, size, 1.0)
    limits = capsule.friction * normal_forces(capsule, np.column_stack([r.real, r.imag]))
    moments = ((supports - mu * r[:, None]).conjugate() * unit).real
    return np.asarray((limits * 1j * unit).sum(axis=1)), np.asarray((limits * moments).sum(axis=1))


def turn_correction(
    capsule: Capsule, radius: float, slider_angle: float, start: float = 0.0
) -> TurnCorrection:
    """Coefficients of tau^2 in the pose at 2 tau and at rest (eqs. 3-6), and of tau in the
    velocities at 2 tau, for a slider that moves by `slider_angle` Z tau^2 [rad] from `start` [rad]
    on the circle of `radius` [m]."""
    from scipy.integrate import quad_vec

    body_angle = -inertia_ratio(capsule, radius) * slider_angle

    def integrand(phase: float) -> Any:
        return _accelerations(capsule, radius, slider_angle, start, np.array([phase]))[:, 0]

    # The slider's acceleration is reversed at 1.
    push, drift, spin, turned = map(
        complex,
        quad_vec(integrand, 0.0, 2.0, epsabs=0.0, epsrel=CONVERGED, points=(1.0,), limit=PIECES)[0],
    )
    end = radius * np.exp(1j * (start + slider_angle))
    facing = complex(np.exp(1j * body_angle))
    place: Point = (float(end.real), float(end.imag))
    way, turn, lasting = residual_limit(capsule, place, push / facing, spin.real)
    # C is at -mu r from the combined centre: a further turn moves it about that.
    arm = capsule.mass_ratio * complex(end) * facing
    at_stop = drift - 1j * arm * turned.real
    at_rest = drift + facing * way - 1j * arm * (turned.real + turn)
    carried = push - 1j * arm * spin.real
    return TurnCorrection(
        TurnPose(at_stop.real, at_stop.imag, turned.real),
        TurnPose(at_rest.real, at_rest.imag, turned.real + turn),
        TurnPose(carried.real, carried.imag, spin.real),
        lasting,
    )


def _accelerations(
    capsule: Capsule, radius: float, slider_angle: float, start: float, phases: Array
) -> Complex:
    """Of the combined centre and of the heading, by friction, at `phases`, shape (n,), each also
    times what is left of 2 tau: shape (4, n)."""
    done, sense = progress(phases), math.copysign(1.0, slider_angle)
    force, moment = leading_friction(capsule, radius, start + slider_angle * done, sense)
    body_angle = -inertia_ratio(capsule, radius) * slider_angle
    push = force * np.exp(1j * body_angle * done) / (capsule.body_mass + capsule.slider_mass)
    spin_up = moment / circle_inertia(capsule, radius)
    left = 2.0 - phases
    return np.stack([push, left * push, spin_up + 0j, left * spin_up])


def residual_limit(
    capsule: Capsule, slider: Point, velocity: complex, omega: float
) -> tuple[complex, float, float]:
    """Displacement of the combined centre and turn of the body over lambda^2, and time to rest over
    lambda, when it coasts from lambda times a velocity and an angular velocity, lambda -> 0.

    `slider` r [m] in body axes; `velocity` of the combined centre [m/s^2], complex, body axes;
    `omega` [rad/s^2]: each per second of tau. In the limit the body does not turn while it stops
    and friction depends on the direction of (velocity, omega) alone: the displacement is
    homogeneous of degree two.
    """
    arm = capsule.mass_ratio * complex(*slider)
    lever = float(max(abs(complex(*point) - arm) for point in capsule.supports))
    speed = abs(velocity) + lever * abs(omega)
    if speed == 0.0:
        return 0j, 0.0, 0.0
    # A stop from speed v turns the body by about v^2/(f g lever).
    scale = float(np.sqrt(SLOW**2 * capsule.friction * capsule.gravity * lever)) / speed
    body_velocity = scale * (velocity - 1j * omega * arm)
    start = Start((body_velocity.real, body_velocity.imag), scale * omega)
    motion = three_point_motion(capsule, fixed(slider), start)
    end = motion.at(np.array([motion.rest_time]))
    turn = float(end.heading[0])
    way = complex(*end.position[0]) + arm * np.expm1(1j * turn)
    return way / scale**2, turn / scale**2, motion.rest_time / scale
