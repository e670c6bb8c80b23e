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

LINEAR = 1e-9  # of a segment's length in time: it runs in time itself
NODES = 16  # Gauss points of a segment, for the mean square; for the peak its ends as well


@dataclass(frozen=True)
class Loading:
    """Motion of a segment at n times, plane vectors complex and in body axes, and the forces that
    its accelerations need."""

    body: Mechanics
    at: Configuration
    states: Array  # p_x, p_y, omega, t, psi and the place of C, shape (n, 7)
    rates: Array  # of (p_x, p_y, omega) by time, shape (n, 3)
    pace: Array  # d(time)/d(fraction) [s]

    @property
    def point(self) -> Complex:
        """p [m/s]."""
        return np.asarray(self.states[:, 0] + 1j * self.states[:, 1])

    @property
    def acceleration(self) -> Complex:
        """Of G [m/s^2]."""
        mu = self.body.mass_ratio
        omega = self.states[:, 2]
        carried = self.rates[:, :2] @ [1.0, 1j]
        turned = 1j * omega * (self.point + mu * self.at.velocity)
        return np.asarray(carried + mu * self.at.acceleration + turned)

    @property
    def friction(self) -> tuple[Complex, Array]:
        """Resultant of friction [N] and its moment about G [N m] (Chernousko 2020, eqs. 2-4)."""
        r = self.at.position
        v = self.at.velocity
        w = self.at.acceleration
        growth = cross(r, w) + 2.0 * (r.conjugate() * v).real * self.states[:, 2]
        moment = self.at.inertia * self.rates[:, 2] + self.body.reduced_mass * growth
        return self.body.mass * self.acceleration, moment

    @property
    def actuator(self) -> Complex:
        """Force F of the actuators on the slider [N] (Chernousko 2020, eq. 3)."""
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
    """Loading at `fractions` of a segment, in [0, 1], shape (n,)."""
    places = segment.last * fractions
    states = evaluate(segment.coefficients, places)
    slopes = evaluate(np.asarray(2.0 * legder(segment.coefficients)), places)
    at = segment.interval.at(states[:, 3])
    if (
        np.abs(segment.coefficients[2:, 3]).max(initial=0.0)
        <= LINEAR * segment.coefficients[1, 3]
    ):
        rates = slopes[:, :3] / slopes[:, 3:4]
    else:  # in sigma, where nothing is left of a slope at the end, but all supports slide
        rates = sliding_rates(motion.body, at, states, derived=False)[0][:, :3]
    return Loading(motion.body, at, states, rates, slopes[:, 3] * segment.last)


def plane_demand(motion: ThreePointMotion) -> Demand:
    """The demand of `motion` until the slider stops: the magnitude of the force, and the power
    that it gives to the slider in the body."""
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
