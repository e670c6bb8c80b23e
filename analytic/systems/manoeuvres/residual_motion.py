"""Residual motion in closed form: Q fixed, body and slider coast to rest with dry friction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.parameters import ParameterError, finite, positive
from plumbob.analytic.reference import Array, LinearResponse
from plumbob.analytic.systems.capsule import (
    Capsule,
    Point,
    Segment,
    by_support,
    normal_force_uncertainty,
    normal_forces,
    validity,
)
from plumbob.analytic.systems.capsule_motion import MotionKind, SingleMotion
from plumbob.analytic.systems.slider_path import SliderPath, fixed

ROUNDINGS = 32  # upper bound: of the parameters, and between them and a place
ROUND = 1e-12  # largest relative difference of arms that count as equal

# Spin and translation are coupled, and in general there is no formula. There is one when each
# support moves on a circle and the sum of friction forces, f N_i against its motion, is constant:
#   translation: any Q, since sum f N_i d passes through the centre of pressure, which is mu r;
#   spin about the combined centre G = mu r: sum N_i (A_i - G) = 0 always, so the forces cancel only
#     if the arms |A_i - G| are equal, that is if G is the circumcentre.


@dataclass(frozen=True)
class ResidualMotion(SingleMotion, LinearResponse):
    """`capsule` that at first turns about `centre` [m, relative to C] at `rate` [rad/s], or if
    `centre` is None translates along `direction` [rad] at `rate` [m/s], of either sign, and stops
    under a constant positive `deceleration` [m/s^2 or rad/s^2], with Q at `slider` relative to C
    [m]; at the start C is the origin and the heading is 0."""

    capsule: Capsule
    rate: float
    deceleration: float
    centre: Point | None
    direction: float = 0.0
    slider: Point = (0.0, 0.0)
    kind: ClassVar[MotionKind] = "coasting"

    @property
    def path(self) -> SliderPath:
        """The fixed slider."""
        return fixed(self.slider)

    @property
    def sliding_time(self) -> float:
        """Time to rest [s], |rate|/deceleration."""
        return abs(self.rate) / self.deceleration

    @property
    def distance(self) -> float:
        """Signed way to rest [m or rad], rate |rate|/(2 deceleration)."""
        return 0.5 * self.rate * self.sliding_time

    def course(self, times: Array) -> tuple[Array, Array]:
        """Way since the start [m or rad] and its rate, at `times` [s], shape (n,) each."""
        left = np.maximum(self.sliding_time - times, 0.0)
        braked = math.copysign(self.deceleration, self.rate)
        return np.asarray(self.distance - 0.5 * braked * left**2), braked * left

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Exact x, y of C [m], velocity_x, velocity_y [m/s], heading [rad], heading_rate [rad/s]
        and normal_force_1..3 [N] at `times` [s], shape (n,)."""
        place: Any
        speed: Any
        way, rate = self.course(np.asarray(times, dtype=np.float64))
        if self.centre is None:
            along = complex(math.cos(self.direction), math.sin(self.direction))
            place, speed, way, rate = way * along, rate * along, 0.0 * way, 0.0 * rate
        else:
            arm = -complex(*self.centre) * np.exp(1j * way)
            place, speed = complex(*self.centre) + arm, 1j * rate * arm
        return {
            "x": place.real,
            "y": place.imag,
            "velocity_x": speed.real,
            "velocity_y": speed.imag,
            "heading": way,
            "heading_rate": rate,
            **by_support(np.tile(_placed(self.capsule, self.slider), (len(way), 1))),
        }

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Absolute error [SI] at `times` [s], shape (n,), that parameters and times rounded to
        double, and the arithmetic, may have caused."""
        few = ROUNDINGS * ROUNDOFF
        way, rate = few * abs(self.distance), few * abs(self.rate)
        load = normal_force_uncertainty(self.capsule, math.hypot(*self.slider))
        bounds = (way, way, rate, rate, 0.0, 0.0, *3 * (load,))
        if self.centre is not None:
            arm = math.hypot(*self.centre)
            moved, speed = arm * (way + few), arm * (rate + abs(self.rate) * (way + few))
            bounds = (moved, moved, speed, speed, way, rate, *3 * (load,))
        names = self.observe(np.zeros(1))
        return {
            name: np.full(np.shape(times), bound) for name, bound in zip(names, bounds, strict=True)
        }


def _placed(capsule: Capsule, slider: Point) -> Array:
    """Normal forces [N], shape (3,), with Q at `slider`. Raises ParameterError."""
    positive("friction", capsule.friction)
    place = (finite("slider", slider[0]), finite("slider", slider[1]))
    for breach in validity(capsule, (Segment(place, place),)):
        raise breach
    return np.asarray(normal_forces(capsule, np.array([place]))[0])


def translation(capsule: Capsule, slider: Point, speed: float, direction: float) -> ResidualMotion:
    """Coasting without spin at `speed` [m/s] along `direction` [rad], Q at `slider` relative to C
    [m]: over v0^2/(2 f g) in v0/(f g), wherever Q is. Raises ParameterError."""
    _placed(capsule, slider)
    deceleration, direction = capsule.friction * capsule.gravity, finite("direction", direction)
    return ResidualMotion(capsule, finite("speed", speed), deceleration, None, direction, slider)


def spin(capsule: Capsule, slider: Point, rate: float) -> ResidualMotion:
    """Coasting about the combined centre mu r at `rate` [rad/s], Q at `slider` relative to C [m].

    The supports must be at one distance R from that centre (from C, with Q at C); then
    (J + mu M r^2) omega' = -f (M + m) g R. Raises ParameterError otherwise. Chernousko 2020, eq.
    23 with v = w = 0.
    """
    _placed(capsule, slider)
    mu = capsule.mass_ratio
    centre = (mu * slider[0], mu * slider[1])
    arms = [math.dist(centre, support) for support in capsule.supports]
    if max(arms) - min(arms) > ROUND * max(arms):
        need = f"equally far from the combined centre, not {', '.join(f'{a:.6g}' for a in arms)} m"
        raise ParameterError("supports", capsule.supports, need)
    inertia = capsule.inertia + mu * capsule.body_mass * (slider[0] ** 2 + slider[1] ** 2)
    torque = capsule.friction * capsule.weight * sum(arms) / 3
    return ResidualMotion(capsule, finite("rate", rate), torque / inertia, centre, slider=slider)
