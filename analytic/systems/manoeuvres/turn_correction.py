"""Second order of the turn manoeuvre: what friction does along its leading-order motion.

Chernousko 2020 stops at eq. 32, the leading order; analytic/README.md derives the rest, by the
equation numbers used here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule, Point, normal_forces
from plumbob.analytic.systems.manoeuvres.residual_limit import residual_limit
from plumbob.analytic.systems.three_points.equations import Complex

CONVERGED = 1e-14  # of the quadrature, relative
SHARPEST_STEP = 2.0**-7  # a kink between the marked places would end here


@dataclass(frozen=True)
class TurnPose:
    """Place of C relative to its start [m] and change of heading [rad]; as a second-order
    coefficient the same over tau^2, [m/s^2] and [rad/s^2]."""

    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class TurnCorrection:
    """Coefficients of tau^2 in the pose when the slider stops (2 tau) and when the body rests, and
    of tau in the time from one to the other."""

    at_stop: TurnPose
    at_rest: TurnPose
    residual_time: float


def circle_inertia(capsule: Capsule, radius: float) -> float:
    """J + mu M a^2 [kg m^2], of body and slider about their combined centre, with the slider on
    the circle of `radius` a [m] about C (Chernousko 2020, eqs. 23, 25)."""
    return capsule.inertia + capsule.mass_ratio * capsule.body_mass * radius**2


def inertia_ratio(capsule: Capsule, radius: float) -> float:
    """mu_1 = mu M a^2/(J + mu M a^2) (Chernousko 2020, eq. 25)."""
    reduced = capsule.mass_ratio * capsule.body_mass
    return reduced * radius**2 / circle_inertia(capsule, radius)


def progress(shares: Array) -> Array:
    """Part of the slider's way that is done at times `shares` tau, shape (n,), up to 2 tau
    (Chernousko 2020, eqs. 26, 29)."""
    return np.asarray(0.5 * np.square(shares) - np.square(np.maximum(shares - 1.0, 0.0)))


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
    """Coefficients of tau^2 in the pose at 2 tau and at rest (eqs. 3-6), for a slider that goes
    round by `slider_angle` Z tau^2 [rad] from `start` [rad] on the circle of `radius` [m]."""
    mass, inertia = capsule.body_mass + capsule.slider_mass, circle_inertia(capsule, radius)
    body_angle = -inertia_ratio(capsule, radius) * slider_angle

    def accelerations(shares: Array) -> Complex:
        done = progress(shares)
        force, moment = leading_friction(
            capsule, radius, start + slider_angle * done, math.copysign(1.0, slider_angle)
        )
        push = force * np.exp(1j * body_angle * done) / mass
        spin_up = moment / inertia
        left = 2.0 - shares
        return np.stack([push, left * push, spin_up + 0j, left * spin_up])

    push, drift, spin, turned = _integral(accelerations, _marks(capsule, slider_angle, start))
    end = radius * np.exp(1j * (start + slider_angle))
    facing = complex(np.exp(1j * body_angle))
    place: Point = (float(end.real), float(end.imag))
    way, turn, lasting = residual_limit(capsule, place, push / facing, spin.real)
    # C is at -mu r from the combined centre: a further turn swings it about that.
    arm = capsule.mass_ratio * complex(end) * facing
    at_stop = drift - 1j * arm * turned.real
    at_rest = drift + facing * way - 1j * arm * (turned.real + turn)
    return TurnCorrection(
        TurnPose(at_stop.real, at_stop.imag, turned.real),
        TurnPose(at_rest.real, at_rest.imag, turned.real + turn),
        lasting,
    )


def _marks(capsule: Capsule, slider_angle: float, start: float) -> list[float]:
    """Times over tau at which friction turns fastest: where r points away from a support; and where
    the slider's acceleration is reversed."""
    marks, reach = {0.0, 1.0, 2.0}, abs(slider_angle)
    for x, y in capsule.supports:
        first = math.copysign(1.0, slider_angle) * (math.atan2(y, x) + math.pi - start)
        for angle in np.arange(first % (2 * math.pi), reach, 2 * math.pi):
            done = float(angle) / reach
            late = 2.0 - math.sqrt(2.0 * (1.0 - done))
            marks.add(math.sqrt(2.0 * done) if done < 0.5 else late)
    return sorted(marks)


def _integral(function: Callable[[Array], Complex], marks: list[float]) -> list[complex]:
    """Integrals of the rows of `function` over all the marks, by the tanh-sinh rule from mark to
    mark, which does not mind how sharply a row bends at a mark."""
    edges = np.array(marks)
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    step, before = 0.25, np.full(4, np.inf + 0j)
    while True:
        t = np.arange(-4.0, 4.0 + 0.5 * step, step)
        bend = 0.5 * math.pi * np.sinh(t)
        weights = step * 0.5 * math.pi * np.cosh(t) / np.cosh(bend) ** 2
        places = (middle[:, None] + half[:, None] * np.tanh(bend)).ravel()
        values = function(places) * (half[:, None] * weights).ravel()
        total = values.sum(axis=1)
        settled = np.all(np.abs(total - before) <= CONVERGED * np.abs(values).sum(axis=1))
        if settled or step <= SHARPEST_STEP:
            return [complex(value) for value in total]
        step, before = 0.5 * step, total
