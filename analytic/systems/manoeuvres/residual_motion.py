"""Residual motion in closed form: Q fixed, body and slider coast to rest with dry friction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

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
class Coasting:
    """One coordinate q that starts at rate q' and stops under a constant deceleration.

    `rate` [m/s or rad/s], of either sign; `deceleration` [m/s^2 or rad/s^2], positive.
    """

    rate: float
    deceleration: float

    @property
    def duration(self) -> float:
        """Time to rest [s], |q'|/deceleration."""
        return abs(self.rate) / self.deceleration

    @property
    def distance(self) -> float:
        """Signed way to rest [m or rad], q'|q'|/(2 deceleration)."""
        return 0.5 * self.rate * self.duration

    def rates(self, times: Array) -> Array:
        """Rate at `times` [s], shape (n,)."""
        left = np.maximum(self.duration - times, 0.0)
        return math.copysign(self.deceleration, self.rate) * left

    def ways(self, times: Array) -> Array:
        """Way since the start at `times` [s], shape (n,)."""
        spent = np.minimum(times, self.duration)
        braked = 0.5 * math.copysign(self.deceleration, self.rate)
        return np.where(times < self.duration, spent * (self.rate - braked * spent), self.distance)


@dataclass(frozen=True)
class ResidualMotion(SingleMotion, LinearResponse):
    """`capsule` that turns about `centre` [m, relative to C, at the start], or if `centre` is None
    translates along `direction` [rad], with Q at `slider` relative to C [m]; at the start C is the
    origin and the heading is 0."""

    capsule: Capsule
    coasting: Coasting
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
        """Time to rest [s]."""
        return self.coasting.duration

    @property
    def duration(self) -> float:
        """Time to rest [s]."""
        return self.coasting.duration

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Exact x, y of C [m], velocity_x, velocity_y [m/s], heading [rad], heading_rate [rad/s]
        and normal_force_1..3 [N] at `times` [s], shape (n,)."""
        times = np.asarray(times, dtype=np.float64)
        way, rate = self.coasting.ways(times), self.coasting.rates(times)
        if self.centre is None:
            cos, sin = math.cos(self.direction), math.sin(self.direction)
            place, speed = (way * cos, way * sin), (rate * cos, rate * sin)
            way = rate = np.zeros_like(times)
        else:
            (x, y), cos_way, sin_way = self.centre, np.cos(way), np.sin(way)
            arm = (-x * cos_way + y * sin_way, -x * sin_way - y * cos_way)
            place, speed = (x + arm[0], y + arm[1]), (-rate * arm[1], rate * arm[0])
        return {
            "x": place[0],
            "y": place[1],
            "velocity_x": speed[0],
            "velocity_y": speed[1],
            "heading": way,
            "heading_rate": rate,
            **by_support(np.tile(_placed(self.capsule, self.slider), (len(times), 1))),
        }

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Absolute error [SI] at `times` [s], shape (n,), that parameters and times rounded to
        double, and the arithmetic, may have caused."""
        still, few = np.zeros_like(np.asarray(times, dtype=np.float64)), ROUNDINGS * ROUNDOFF
        way = few * abs(self.coasting.distance)
        rate = few * abs(self.coasting.rate)
        arm = 1.0 if self.centre is None else math.hypot(*self.centre)
        turned = 0.0 if self.centre is None else 1.0
        moved = arm * (way + few * turned)
        speed = arm * (rate + turned * (abs(self.coasting.rate) * (way + few)))
        load = normal_force_uncertainty(self.capsule, math.hypot(*self.slider))
        bounds = (moved, moved, speed, speed, turned * way, turned * rate, *3 * (load,))
        return {
            name: still + bound for name, bound in zip(self.observe(still), bounds, strict=True)
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
    deceleration = capsule.friction * capsule.gravity
    return ResidualMotion(
        capsule,
        Coasting(finite("speed", speed), deceleration),
        None,
        finite("direction", direction),
        slider,
    )


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
    return ResidualMotion(
        capsule, Coasting(finite("rate", rate), torque / inertia), centre, slider=slider
    )
