"""Slow motion: slider moved, or gravity tilted, with friction holding the body."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from analytic.capsule import (
    ROUNDOFF,
    Capsule,
    Point,
    Segment,
    normal_force_uncertainty,
    normal_forces,
    validity,
)
from analytic.line_manoeuvre import LineManoeuvre
from analytic.line_reference import position_lead
from analytic.parameters import ParameterError, finite, positive
from analytic.reference import Array

ROUNDINGS = 32  # of the parameters and on the way from them to a stroke, generously


def _share(name: str, value: float) -> float:
    if not 0.0 < finite(name, value) <= 1.0:
        raise ParameterError(name, value, "above 0 and at most 1")
    return float(value)


def tilt_angle(capsule: Capsule, fraction: float = 1.0) -> float:
    """Tilt of gravity [rad] at which its tangential part is `fraction` of what friction can hold:
    tan(alpha) = fraction f.

    Weight acts at the combined centre mu r, which is also the centre of pressure, so every support
    does its share of N_i and the threshold is the same in every direction and wherever Q is fixed
    (heights zero: the tilt moves no load). Raises ParameterError.
    """
    return math.atan(_share("fraction", fraction) * capsule.friction)


def tilted_gravity(capsule: Capsule, fraction: float, direction: float) -> Array:
    """Gravity [m/s^2], shape (3,), of unchanged magnitude, tilted by `tilt_angle` so as to pull
    along `direction` [rad, from the body's x axis]. Raises ParameterError."""
    angle, heading = tilt_angle(capsule, fraction), finite("direction", direction)
    down, along = math.cos(angle), math.sin(angle)
    pull = np.array([along * math.cos(heading), along * math.sin(heading), -down])
    return capsule.gravity * pull


@dataclass(frozen=True)
class SlowStroke:
    """Slider along a line through C, out and if wanted back, while friction holds the body.

    Each way takes +W for half its time and -W for the other half, W = `fraction` f g/mu [m/s^2]:
    the quickest stroke from rest to rest under |w| <= W. `length` [m] is signed along `direction`
    [rad, from the body's x axis]; the slider starts at `start` [m] along it, from C. At fraction 1
    friction is used up. Raises ParameterError. Chernousko 2020, eq. 21.
    """

    capsule: Capsule
    length: float
    fraction: float = 1.0
    direction: float = 0.0
    start: float = 0.0
    there_and_back: bool = True

    def __post_init__(self) -> None:
        for name in ("length", "direction", "start"):
            object.__setattr__(self, name, finite(name, getattr(self, name)))
        positive("friction", self.capsule.friction)
        _share("fraction", self.fraction)
        if self.length == 0.0:
            raise ParameterError("length", self.length, "other than 0")
        for breach in validity(self.capsule, (self.path,)):
            raise breach

    @property
    def path(self) -> Segment:
        """The slider's path relative to C."""
        x, y = math.cos(self.direction), math.sin(self.direction)
        end = self.start + self.length
        return Segment((self.start * x, self.start * y), (end * x, end * y))

    @property
    def acceleration(self) -> float:
        """W [m/s^2]."""
        return self.fraction * self.capsule.holding_acceleration

    @property
    def one_way(self) -> float:
        """Time for one way [s], 2 sqrt(|length|/W)."""
        return 2.0 * math.sqrt(abs(self.length) / self.acceleration)

    @property
    def duration(self) -> float:
        """Time until the slider rests at the end [s]."""
        return self.one_way * (2 if self.there_and_back else 1)

    def _outward(self, times: Array) -> tuple[npt.NDArray[np.bool_], Array]:
        """Whether the slider is on its way back, and the time on the way out at which it is, or
        was, where it is now [s]: the way back is the way out in reverse."""
        spent = np.clip(times, 0.0, self.duration)
        mirrored = self.one_way - np.abs(spent - self.one_way)
        return spent > self.one_way, np.maximum(mirrored, 0.0)

    def relative_acceleration(self, times: Array) -> Array:
        """Slider's acceleration in the body w [m/s^2] at `times` [s], shape (n,); a time at which
        it switches counts to the interval that it opens."""
        back, outward = self._outward(times)
        half = 0.5 * self.one_way
        speeding = (outward < half) | (back & (outward == half))
        signed = math.copysign(self.acceleration, self.length)
        return np.where(times < self.duration, np.where(speeding, signed, -signed), 0.0)

    def relative_velocity(self, times: Array) -> Array:
        """Slider's velocity in the body v [m/s] at `times` [s], shape (n,)."""
        back, outward = self._outward(times)
        signed = math.copysign(self.acceleration, self.length)
        speed = np.minimum(outward, np.maximum(self.one_way - outward, 0.0))
        return np.where(back, -signed, signed) * speed

    def mean_relative_acceleration(self, edges: Array) -> Array:
        """Mean of w over each step between `edges` [s], shape (n+1,): shape (n,) [m/s^2]."""
        return np.diff(self.relative_velocity(edges)) / np.diff(edges)

    def strokes(self, times: Array) -> Array:
        """Slider's displacement in the body xi [m] at `times` [s], shape (n,)."""
        _, outward = self._outward(times)
        half, bend = 0.5 * self.one_way, 0.5 * math.copysign(self.acceleration, self.length)
        late = self.length - bend * (self.one_way - outward) ** 2
        return np.where(outward < half, bend * outward**2, late)

    def normal_forces(self, times: Array) -> Array:
        """Normal forces N_i [N] at `times` [s], shape (n, 3)."""
        unit = np.array([math.cos(self.direction), math.sin(self.direction)])
        places = (self.start + self.strokes(times))[:, None] * unit
        return normal_forces(self.capsule, places)

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Exact observables at `times` [s], shape (n,), as `analytic.line_reference` names them:
        the body does not move, and friction is m w."""
        times = np.asarray(times, dtype=np.float64)
        still, forces = np.zeros_like(times), self.normal_forces(times)
        return {
            **dict.fromkeys(("displacement", "velocity", "heading", "sideways"), still),
            "stroke": self.strokes(times),
            "stroke_rate": self.relative_velocity(times),
            **{f"normal_force_{i + 1}": forces[:, i] for i in range(3)},
            "friction_force": self.capsule.slider_mass * self.relative_acceleration(times),
        }

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Absolute error [SI] at `times` [s], shape (n,), that parameters and times rounded to
        double, and the arithmetic, may have caused."""
        times = np.asarray(times, dtype=np.float64)
        still, few = np.zeros_like(times), ROUNDINGS * ROUNDOFF
        reach = abs(self.start) + abs(self.length)
        slack = still + normal_force_uncertainty(self.capsule, reach)
        pull = self.capsule.slider_mass * self.acceleration
        quarters = 2 * times / self.one_way
        at_switch = np.abs(quarters - np.round(quarters)) <= few * np.maximum(quarters, 1.0)
        return {
            **dict.fromkeys(("displacement", "velocity", "heading", "sideways"), still),
            "stroke": still + few * abs(self.length),
            "stroke_rate": still + few * self.acceleration * self.duration,
            **{f"normal_force_{i + 1}": slack for i in range(3)},
            "friction_force": few * pull + np.where(at_switch, 2 * pull, 0.0),
        }

    def leading_error(self, scheme: str, times: Array) -> Mapping[int, Mapping[str, Array]]:
        """Coefficients of the step [s] in the error of semi-implicit Euler at grid `times` [s],
        shape (n,), as for `analytic.line_reference`."""
        if (lead := position_lead(scheme)) is None:
            return {}
        still = np.zeros_like(np.asarray(times, dtype=np.float64))
        first = dict.fromkeys(("displacement", "velocity", "heading", "sideways"), still)
        ahead = lead * self.relative_velocity(times)
        return {1: {**first, "stroke": ahead, "stroke_rate": still}}


@dataclass(frozen=True)
class TiltedHold:
    """Body at rest under gravity tilted along `direction` [rad], by `fraction` of the threshold,
    with Q fixed at `slider` relative to C [m]. Raises ParameterError."""

    capsule: Capsule
    fraction: float
    direction: float = 0.0
    slider: Point = (0.0, 0.0)

    def __post_init__(self) -> None:
        tilted_gravity(self.capsule, self.fraction, self.direction)
        for breach in validity(self.capsule, (Segment(self.slider, self.slider),)):
            raise breach

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Exact observables at `times` [s], shape (n,): nothing moves, friction carries the
        weight's tangential part (signed along `direction`), the N_i the rest of it."""
        still = np.zeros_like(np.asarray(times, dtype=np.float64))
        angle = tilt_angle(self.capsule, self.fraction)
        forces = math.cos(angle) * normal_forces(self.capsule, np.array([self.slider]))[0]
        names = ("displacement", "velocity", "heading", "sideways", "stroke", "stroke_rate")
        return {
            **dict.fromkeys(names, still),
            **{f"normal_force_{i + 1}": still + forces[i] for i in range(3)},
            "friction_force": still - self.capsule.weight * math.sin(angle),
        }

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Absolute error [SI] at `times` [s], shape (n,), of forces; rest is exact."""
        slack = normal_force_uncertainty(self.capsule, math.hypot(*self.slider))
        few = ROUNDINGS * ROUNDOFF * self.capsule.weight
        return {
            name: np.zeros_like(value)
            + (slack if name.startswith("normal") else few if name == "friction_force" else 0.0)
            for name, value in self.observe(times).items()
        }

    def leading_error(self, scheme: str, times: Array) -> Mapping[int, Mapping[str, Array]]:
        """Empty: a body at rest has no error of the step."""
        return {}


def slow_return(manoeuvre: LineManoeuvre, fraction: float = 1.0) -> SlowStroke:
    """The slow motion that takes the slider back to where `manoeuvre` began. Raises
    ParameterError. Chernousko 2020, end of the section on rectilinear motions."""
    return SlowStroke(
        manoeuvre.capsule,
        -manoeuvre.stroke,
        fraction,
        manoeuvre.direction,
        manoeuvre.start + manoeuvre.stroke,
        there_and_back=False,
    )
