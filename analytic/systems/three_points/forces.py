"""Forces of friction and of the slider's actuators along a motion on three Coulomb points."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import legder, leggauss

from plumbob.analytic.numerics.collocation import evaluate
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_motion import Demand
from plumbob.analytic.systems.three_points.equations import (
    Complex,
    Configuration,
    Mechanics,
    cross,
    sliding_rates,
)
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.analytic.systems.three_points.smooth_segment import SmoothSegment

LINEAR = 1e-9  # largest nonlinear coefficient of a time series that counts as linear, relative
# Gauss points of a segment for the mean square; the peak uses the segment's ends too
NODES = 16


@dataclass(frozen=True)
class Loading:
    """A segment's motion at n times, from which the forces follow. Plane vectors are complex
    numbers in body axes."""

    body: Mechanics
    at: Configuration
    states: Array  # p_x, p_y, omega, t, psi and the place of C, shape (n, 7)
    rates: Array  # time derivatives of (p_x, p_y, omega), shape (n, 3)
    pace: Array  # d(time)/d(fraction) [s]

    @property
    def point(self) -> Complex:
        """Velocity p of the body's point at the combined centre G [m/s], shape (n,)."""
        return np.asarray(self.states[:, 0] + 1j * self.states[:, 1])

    @property
    def acceleration(self) -> Complex:
        """Acceleration of the combined centre G [m/s^2], shape (n,)."""
        mu = self.body.mass_ratio
        omega = self.states[:, 2]
        carried = self.rates[:, :2] @ [1.0, 1j]
        turned = 1j * omega * (self.point + mu * self.at.velocity)
        return np.asarray(carried + mu * self.at.acceleration + turned)

    @property
    def friction(self) -> tuple[Complex, Array]:
        """Resultant of the friction forces [N], and their moment about G [N m], shape (n,) each
        (Chernousko 2020, eqs. 2-4)."""
        r = self.at.position
        v = self.at.velocity
        w = self.at.acceleration
        growth = cross(r, w) + 2.0 * (r.conjugate() * v).real * self.states[:, 2]
        moment = self.at.inertia * self.rates[:, 2] + self.body.reduced_mass * growth
        return self.body.mass * self.acceleration, moment

    @property
    def actuator(self) -> Complex:
        """Force F of the actuators on the slider [N], shape (n,) (Chernousko 2020, eq. 3)."""
        r = self.at.position
        v = self.at.velocity
        omega = self.states[:, 2]
        relative = (
            self.at.acceleration + 2j * omega * v + (1j * self.rates[:, 2] - omega**2) * r
        )
        mu = self.body.mass_ratio
        # Q is at (1 - mu) r from G.
        return np.asarray(self.body.mass * mu * (self.acceleration + (1.0 - mu) * relative))


def loading(motion: ThreePointMotion, segment: SmoothSegment, fractions: Array) -> Loading:
    """Returns the loading of a segment at `fractions` of its length, in [0, 1], shape (n,)."""
    places = segment.last * fractions
    states = evaluate(segment.coefficients, places)
    slopes = evaluate(np.asarray(2.0 * legder(segment.coefficients)), places)
    at = segment.interval.at(states[:, 3])
    if (
        np.abs(segment.coefficients[2:, 3]).max(initial=0.0)
        <= LINEAR * segment.coefficients[1, 3]
    ):
        rates = slopes[:, :3] / slopes[:, 3:4]
    else:  # the segment runs in sigma: slopes vanish at its end, so the equations give the rates
        rates = sliding_rates(motion.body, at, states, derived=False)[0][:, :3]
    return Loading(motion.body, at, states, rates, slopes[:, 3] * segment.last)


def plane_demand(motion: ThreePointMotion) -> Demand:
    """Returns what `motion` asks of the actuators until the slider stops: peak and root mean square
    of the force's magnitude, and the peak power given to the slider in the body."""
    x, weights = leggauss(NODES)
    fractions = np.concatenate([[0.0], 0.5 * (x + 1.0), [1.0]])
    stop = motion.path.duration
    peak = power = square = 0.0
    for begin, segment in zip(motion.begins, motion.segments, strict=True):
        if begin < stop * (1.0 - 1e-12):
            load = loading(motion, segment, fractions)
            sizes = np.abs(load.actuator)
            powers = np.abs((load.actuator.conjugate() * load.at.velocity).real)
            peak = max(peak, float(sizes.max()))
            power = max(power, float(powers.max()))
            square += float((0.5 * weights * load.pace[1:-1]) @ sizes[1:-1] ** 2)
    return Demand(peak, math.sqrt(square / stop) if stop else 0.0, power)
