"""Balances of a motion on three Coulomb points: energy, momentum, angular momentum.

Friction and actuator are integrated along the motion by an independent quadrature and compared with
the change of energy and momentum from first state to last, so that a jump at an event would show.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import legder, leggauss

from plumbob.analytic.numerics.collocation import evaluate
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.three_points.equations import Complex, Mechanics, cross
from plumbob.analytic.systems.three_points.forces import Loading, moving, resting
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.analytic.systems.three_points.smooth_segment import SmoothSegment

TINY = 1e-300  # avoids 0/0 for a body at rest throughout
QUADRATURE = 64  # Gauss points per segment: its polynomials have degree 30 at most


@dataclass(frozen=True)
class Balance:
    """Relative residuals of energy, momentum and angular momentum about the ground's origin, each
    over the total exchange; `friction_work` [J] over the whole motion."""

    energy: float
    momentum: float
    angular_momentum: float
    friction_work: float


def actuator_force(body: Mechanics, load: Loading) -> Complex:
    """Force F of the actuator on the slider [N], body axes, shape (n,) (Chernousko 2020, eq. 3)."""
    at, omega, mu = load.at, load.omega, body.mass_ratio
    r, v, w = at.position, at.velocity, at.acceleration
    growth = body.reduced_mass * (2.0 * (r.conjugate() * v).real * omega + cross(r, w))
    spin_up = (load.torque - growth) / at.inertia
    relative = w + 2j * omega * v + 1j * spin_up * r - omega**2 * r
    # Q is at (1 - mu) r from G.
    return body.mass * mu * (load.force / body.mass + (1.0 - mu) * relative)


def actuator_power(body: Mechanics, load: Loading) -> Array:
    """Power F . v of the actuator [W], shape (n,)."""
    return (actuator_force(body, load).conjugate() * load.at.velocity).real


def _totals(body: Mechanics, load: Loading) -> Array:
    """Energy [J], momentum (2) [N s] and angular momentum [N m s], shape
    (n, 4)."""
    at = load.at
    within = at.velocity + 1j * load.omega * at.position
    energy = 0.5 * (
        body.mass * np.abs(load.centre) ** 2
        + body.reduced_mass * np.abs(within) ** 2
        + body.body_inertia * load.omega**2
    )
    momentum = body.mass * load.centre * np.exp(1j * load.heading)
    spin = at.inertia * load.omega + body.reduced_mass * cross(at.position, at.velocity)
    return np.column_stack(
        [energy, momentum.real, momentum.imag, spin + cross(load.place, momentum)]
    )


def _sizes(body: Mechanics, load: Loading) -> Array:
    """Largest energy, momentum and angular momentum of body or slider alone, shape (3,): the scale
    of the round-off of their sums."""
    at = load.at
    within = np.abs(at.velocity + 1j * load.omega * at.position)
    momentum = body.mass * np.abs(load.centre) + body.reduced_mass * within
    angular = body.body_inertia * np.abs(load.omega) + momentum * np.abs(at.position)
    angular = angular + body.mass * np.abs(load.centre) * np.abs(load.place)
    energy = 0.5 * (momentum * (np.abs(load.centre) + within) + body.body_inertia * load.omega**2)
    return np.array([energy.max(), momentum.max(), angular.max()])


def _rates(body: Mechanics, load: Loading) -> Array:
    """Power of friction and of the actuator [W], total force (2) [N] and its moment about the
    ground's origin [N m], shape (n, 5)."""
    resisting = np.where(
        load.velocities == 0.0, 0.0, load.support_forces.conjugate() * load.velocities
    )
    force = load.force * np.exp(1j * load.heading)
    return np.column_stack(
        [
            resisting.real.sum(axis=1),
            actuator_power(body, load),
            *(force.real, force.imag, load.torque + cross(load.place, force)),
        ]
    )


def exchange(
    motion: ThreePointMotion, segment: SmoothSegment, fractions: Array
) -> tuple[Loading, Array]:
    """Loading at `fractions` of a segment, in [0, 1], and d(time)/d(fraction) there [s]."""
    if segment.coefficients is None:
        span = segment.end - segment.start
        times = segment.start + span * fractions
        return resting(motion, segment, times), np.full(fractions.size, span)
    slopes: Array = np.asarray(2.0 * legder(segment.coefficients[:, 3:4]))
    pace = evaluate(slopes, segment.last * fractions)[:, 0] * segment.last
    return moving(motion, segment, segment.last * fractions), pace


def balance(motion: ThreePointMotion) -> Balance:
    """Balances of `motion` from its first state to its final rest."""
    finite = [s for s in motion.segments if np.isfinite(s.end)]
    if not finite:
        return Balance(0.0, 0.0, 0.0, 0.0)
    flow, gross, inside = _exchanged(motion, finite)
    before = _totals(motion.body, exchange(motion, finite[0], np.zeros(1))[0])[0]
    after = _totals(motion.body, exchange(motion, finite[-1], np.ones(1))[0])[0]
    missing = np.abs(after - before - [flow[0] + flow[1], *flow[2:]])
    exchanged = [gross[:2].sum(), gross[2:4].sum(), gross[4]]
    energy, momentum, angular = (
        float(g) + float(i) + TINY for g, i in zip(exchanged, inside, strict=True)
    )
    return Balance(
        energy=float(missing[0]) / energy,
        momentum=float(np.hypot(*missing[1:3])) / momentum,
        angular_momentum=float(missing[3]) / angular,
        friction_work=float(flow[0]),
    )


def _exchanged(
    motion: ThreePointMotion, segments: list[SmoothSegment]
) -> tuple[Array, Array, Array]:
    """Integrals over time of `_rates`, shape (5,), and of their magnitudes, and the largest
    `_sizes`, shape (3,)."""
    x, weights = leggauss(QUADRATURE)
    fractions, weights = 0.5 * (x + 1.0), 0.5 * weights
    flow, gross, inside = np.zeros(5), np.zeros(5), np.zeros(3)
    for segment in segments:
        load, pace = exchange(motion, segment, fractions)
        rates = _rates(motion.body, load) * (weights * pace)[:, None]
        flow, gross = flow + rates.sum(axis=0), gross + np.abs(rates).sum(axis=0)
        inside = np.maximum(inside, _sizes(motion.body, load))
    return flow, gross, inside
