"""Residual motion in closed form: with Q fixed, body and slider coast to rest with dry friction."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.parameters import positive
from plumbob.analytic.reference import Array, LinearResponse, Signals
from plumbob.analytic.systems.capsule import (
    NORMAL_FORCES,
    Capsule,
    PlanePoint,
    by_support,
    check_loads,
    normal_force_uncertainty,
    normal_forces,
)
from plumbob.analytic.systems.capsule_motion import MotionKind, SingleMotion
from plumbob.analytic.systems.slider_path import SliderPath, fixed

# bound on the roundings in the parameters and in the arithmetic of a position
POSITION_ROUNDINGS = 32
EQUAL_ARMS = 1e-12  # largest relative difference of arms that count as equal
RESTING_CENTRE = 1e-12  # [m/s] largest speed of a combined centre that counts as at rest

# Spin and translation are coupled, and in general there is no formula. There are two exceptions:
# each support moves on a straight line or a circle, and the friction forces have a constant sum.
# - Translation, with any Q: the resultant of friction acts at the centre of pressure, which is the
#   combined centre G = mu r, so it has no moment about G.
# - Spin about G: always sum N_i (A_i - G) = 0, so the forces cancel only if the arms |A_i - G| are
#   equal, that is if G is the circumcentre.


@dataclass(frozen=True)
class ResidualMotion(SingleMotion, LinearResponse):
    """A `capsule` that coasts with Q fixed at `slider` relative to C [m], under a constant positive
    `deceleration` [m/s^2 or rad/s^2]. It turns about `centre` [m, relative to C] with the initial
    `rate` [rad/s]. If `centre` is None, it translates along `direction` [rad] with the initial
    `rate` [m/s]. The rate may have either sign. At the start C is the origin and the heading is 0.
    """

    capsule: Capsule
    rate: float
    deceleration: float
    centre: PlanePoint | None
    direction: float = 0.0
    slider: PlanePoint = (0.0, 0.0)
    kind: ClassVar[MotionKind] = "coasting"

    @property
    def path(self) -> SliderPath:
        """The path of the fixed slider."""
        return fixed(self.slider)

    @property
    def sliding_time(self) -> float:
        """Time to rest [s], |rate|/deceleration."""
        return abs(self.rate) / self.deceleration

    @property
    def distance(self) -> float:
        """Signed distance to rest [m or rad], rate |rate|/(2 deceleration)."""
        return 0.5 * self.rate * self.sliding_time

    def distance_and_rate(self, times: Array) -> tuple[Array, Array]:
        """Returns the signed distance since the start [m or rad] and its rate, at `times` [s],
        shape (n,) each."""
        remaining = np.maximum(self.sliding_time - times, 0.0)
        deceleration = math.copysign(self.deceleration, self.rate)
        distance = self.distance - 0.5 * deceleration * remaining**2
        return np.asarray(distance), deceleration * remaining

    def observe(self, times: Array) -> Signals:
        """Exact x, y of C [m], velocity_x, velocity_y [m/s], heading [rad], heading_rate [rad/s]
        and normal_force_1..3 [N] at `times` [s], shape (n,)."""
        position: Any
        velocity: Any
        distance, rate = self.distance_and_rate(np.asarray(times, dtype=np.float64))
        if self.centre is None:
            unit = cmath.rect(1.0, self.direction)
            position = distance * unit
            velocity = rate * unit
            heading = 0.0 * distance
            heading_rate = 0.0 * rate
        else:  # the distance is the heading
            heading = distance
            heading_rate = rate
            arm = -complex(*self.centre) * np.exp(1j * heading)
            position = complex(*self.centre) + arm
            velocity = 1j * heading_rate * arm
        places = np.tile(self.slider, (len(heading), 1))
        return {
            "x": position.real,
            "y": position.imag,
            "velocity_x": velocity.real,
            "velocity_y": velocity.imag,
            "heading": heading,
            "heading_rate": heading_rate,
            **by_support(normal_forces(self.capsule, places)),
        }

    def uncertainty(self, times: Array) -> Signals:
        """Bound on the error of each observable [SI] at `times` [s], shape (n,), by parameters and
        times rounded to double and by the arithmetic."""
        rounding = POSITION_ROUNDINGS * ROUNDOFF
        # In a turn about a centre, the distance is an angle [rad] and the rate is its rate [rad/s].
        distance_error = rounding * abs(self.distance)
        rate_error = rounding * abs(self.rate)
        if self.centre is None:
            position = distance_error
            velocity = rate_error
            heading = heading_rate = 0.0
        else:
            arm = math.hypot(*self.centre)
            position = arm * (distance_error + rounding)
            velocity = arm * (rate_error + abs(self.rate) * (distance_error + rounding))
            heading = distance_error
            heading_rate = rate_error
        load = normal_force_uncertainty(self.capsule, math.hypot(*self.slider))
        bounds = {
            "x": position,
            "y": position,
            "velocity_x": velocity,
            "velocity_y": velocity,
            "heading": heading,
            "heading_rate": heading_rate,
            **dict.fromkeys(NORMAL_FORCES, load),
        }
        return {name: np.full(np.shape(times), bound) for name, bound in bounds.items()}


def coasting(
    capsule: Capsule, slider: PlanePoint, velocity: PlanePoint, rate: float = 0.0
) -> ResidualMotion | None:
    """Returns the coasting of a body whose C has the initial `velocity` [m/s] and which turns with
    the initial `rate` [rad/s], with Q at `slider` relative to C [m]. Returns None if spin and
    translation are coupled. Raises ParameterError.

    Without spin the body moves v0^2/(2 f g) in the time v0/(f g), wherever Q is. If the body turns
    about the combined centre mu r and the supports are all at the distance R from it, then (J + mu
    M r^2) omega' = -f (M + m) g R (Chernousko 2020, eq. 23 with v = w = 0).
    """
    positive("friction", capsule.friction)
    check_loads(capsule, (slider,))
    if rate == 0.0:
        speed = math.hypot(*velocity)
        direction = math.atan2(velocity[1], velocity[0])
        deceleration = capsule.friction * capsule.gravity
        return ResidualMotion(
            capsule=capsule,
            rate=speed,
            deceleration=deceleration,
            centre=None,
            direction=direction,
            slider=slider,
        )
    mu = capsule.mass_ratio
    centre = (mu * slider[0], mu * slider[1])
    arms = [math.dist(centre, support) for support in capsule.supports]
    centre_speed = abs(complex(*velocity) + 1j * rate * complex(*centre))
    if centre_speed > RESTING_CENTRE or max(arms) - min(arms) > EQUAL_ARMS * max(arms):
        return None
    inertia = capsule.inertia + mu * capsule.body_mass * (slider[0] ** 2 + slider[1] ** 2)
    torque = capsule.friction * capsule.weight * sum(arms) / 3
    return ResidualMotion(capsule, rate, torque / inertia, centre, slider=slider)
