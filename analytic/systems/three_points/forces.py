"""Forces of friction and of the slider's actuators along a motion on three Coulomb points."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import legder, leggauss

from plumbob.analytic.numerics.collocation import evaluate
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_motion import ActuatorDemand
from plumbob.analytic.systems.three_points.equations import (
    ComplexForces,
    Configuration,
    Mechanics,
    cross,
    sliding_rates,
)
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.analytic.systems.three_points.smooth_segment import SmoothSegment

# A series in time within a segment counts as linear if no other coefficient is larger than this,
# relative to the linear coefficient.
LINEAR_TIME = 1e-9
# Gauss points of a segment for the mean square; the peak uses the segment's ends too
FORCE_NODES = 16


@dataclass(frozen=True)
class Loading:
    """A segment's motion at n times, from which the forces follow. Plane vectors are complex
    numbers in body axes."""

    body: Mechanics
    terms: Configuration
    states: Array  # p_x, p_y, omega, t, psi and the position of C, shape (n, 7)
    rates: Array  # time derivatives of (p_x, p_y, omega), shape (n, 3)
    pace: Array  # d(time)/d(fraction) [s]

    @property
    def velocity(self) -> ComplexForces:
        """Velocity p of the body's point at the combined centre G [m/s], shape (n,)."""
        return np.asarray(self.states[:, 0] + 1j * self.states[:, 1])

    @property
    def acceleration(self) -> ComplexForces:
        """Acceleration of the combined centre G [m/s^2], shape (n,)."""
        mu = self.body.mass_ratio
        omega = self.states[:, 2]
        velocity_rate = self.rates[:, :2] @ [1.0, 1j]
        axes_rotation = 1j * omega * (self.velocity + mu * self.terms.velocity)
        return np.asarray(velocity_rate + mu * self.terms.acceleration + axes_rotation)

    @property
    def friction(self) -> tuple[ComplexForces, Array]:
        """Resultant of the friction forces [N], and their moment about G [N m], shape (n,) each
        (Chernousko 2020, eqs. 2-4)."""
        r = self.terms.position
        v = self.terms.velocity
        w = self.terms.acceleration
        slider_term = cross(r, w) + 2.0 * (r.conjugate() * v).real * self.states[:, 2]
        moment = self.terms.inertia * self.rates[:, 2] + self.body.reduced_mass * slider_term
        return self.body.mass * self.acceleration, moment

    @property
    def actuator(self) -> ComplexForces:
        """Force F of the actuators on the slider [N], shape (n,) (Chernousko 2020, eq. 3)."""
        r = self.terms.position
        v = self.terms.velocity
        omega = self.states[:, 2]
        rotation = (1j * self.rates[:, 2] - omega**2) * r
        relative_acceleration = self.terms.acceleration + 2j * omega * v + rotation
        mu = self.body.mass_ratio
        # Q is at (1 - mu) r from G.
        slider_acceleration = self.acceleration + (1.0 - mu) * relative_acceleration
        return np.asarray(self.body.mass * mu * slider_acceleration)


def loading(motion: ThreePointMotion, segment: SmoothSegment, fractions: Array) -> Loading:
    """Returns the loading of a segment at `fractions` of its length, in [0, 1], shape (n,)."""
    series = segment.coefficients
    parameters = segment.last * fractions
    states = evaluate(series, parameters)
    derivatives = evaluate(np.asarray(2.0 * legder(series)), parameters)
    terms = segment.interval.at(states[:, 3])
    nonlinear_time = np.abs(series[2:, 3]).max(initial=0.0)
    if nonlinear_time <= LINEAR_TIME * series[1, 3]:
        rates = derivatives[:, :3] / derivatives[:, 3:4]
    else:  # the segment runs in sigma: its derivatives vanish at the end, so the equations are used
        sliding, _ = sliding_rates(motion.body, terms, states, with_derivatives=False)
        rates = sliding[:, :3]
    return Loading(motion.body, terms, states, rates, derivatives[:, 3] * segment.last)


def plane_demand(motion: ThreePointMotion) -> ActuatorDemand:
    """Returns what `motion` asks of the actuators until the slider stops: peak and root mean square
    of the force's magnitude, and the peak power given to the slider in the body."""
    nodes, weights = leggauss(FORCE_NODES)
    fractions = np.concatenate([[0.0], 0.5 * (nodes + 1.0), [1.0]])
    stop = motion.path.duration
    peak_force = peak_power = square_integral = 0.0
    for begin, segment in zip(motion.begins, motion.segments, strict=True):
        if begin < stop * (1.0 - 1e-12):
            load = loading(motion, segment, fractions)
            forces = np.abs(load.actuator)
            powers = np.abs((load.actuator.conjugate() * load.terms.velocity).real)
            peak_force = max(peak_force, float(forces.max()))
            peak_power = max(peak_power, float(powers.max()))
            durations = 0.5 * weights * load.pace[1:-1]
            square_integral += float(durations @ forces[1:-1] ** 2)
    rms = math.sqrt(square_integral / stop) if stop else 0.0
    return ActuatorDemand(peak_force, rms, peak_power)
