"""Slow motion: the slider moves while static friction keeps the body at rest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.parameters import ParameterError, finite, positive
from plumbob.analytic.reference import Array, LinearResponse
from plumbob.analytic.systems.capsule import (
    NORMAL_FORCES,
    Capsule,
    Segment,
    by_support,
    normal_force_uncertainty,
    normal_forces,
    validity,
)
from plumbob.analytic.systems.capsule_motion import MotionKind, SingleMotion
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import SNAP, LineManoeuvre
from plumbob.analytic.systems.slider_path import SliderPath, straight

ROUNDINGS = 32  # upper bound: of the parameters, and between them and a stroke


def proper_fraction(name: str, value: float) -> float:
    """`value` as a fraction above 0 and at most 1; raises ParameterError naming it."""
    if not 0.0 < finite(name, value) <= 1.0:
        raise ParameterError(name, value, "above 0 and at most 1")
    return float(value)


@dataclass(frozen=True)
class SlowStroke(SingleMotion, LinearResponse):
    """Slider along a line through C, out and optionally back, while the body sticks.

    Each stroke has +W for half its time and -W for the other half, W = `fraction` f g/mu [m/s^2]:
    the quickest stroke from rest to rest under |w| <= W. `length` [m] is signed along `direction`
    [rad, from the body's x axis]; the slider starts at `start` [m] along it, from C. At fraction 1
    static friction is at its limit. Raises ParameterError. Chernousko 2020, eq. 21.
    """

    capsule: Capsule
    length: float
    fraction: float = 1.0
    direction: float = 0.0
    start: float = 0.0
    there_and_back: bool = True
    kind: ClassVar[MotionKind] = "stroke"
    sliding_time: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        for name in ("length", "direction", "start"):
            object.__setattr__(self, name, finite(name, getattr(self, name)))
        positive("friction", self.capsule.friction)
        proper_fraction("fraction", self.fraction)
        if self.length == 0.0:
            raise ParameterError("length", self.length, "other than 0")
        for breach in validity(self.capsule, (self.segment,)):
            raise breach

    @cached_property
    def path(self) -> SliderPath:
        """The slider's path in the body."""
        half, pull = 0.5 * self.one_way, math.copysign(self.acceleration, self.length)
        pulls, halves = [pull, -pull], [half, half]
        if self.there_and_back:
            pulls, halves = [pull, -pull, -pull, pull], [half] * 4
        return straight(self.segment.start, self.direction, pulls, halves)

    @property
    def segment(self) -> Segment:
        """The places that the slider covers, relative to C."""
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
        """Whether the slider is returning, and the time of the outward stroke at which it has the
        same place [s]: the return is the outward stroke in reverse."""
        spent = np.clip(times, 0.0, self.duration)
        mirrored = self.one_way - np.abs(spent - self.one_way)
        return spent > self.one_way, np.maximum(mirrored, 0.0)

    def relative_acceleration(self, times: Array) -> Array:
        """Slider's acceleration in the body w [m/s^2] at `times` [s], shape (n,); a time at which
        it switches belongs to the interval that begins there."""
        times = times * (1.0 + SNAP)
        back, outward = self._outward(times)
        half = 0.5 * self.one_way
        speeding = (outward < half) | (back & (outward == half))
        signed = math.copysign(self.acceleration, self.length)
        moving = (times >= 0.0) & (times < self.duration)
        return np.where(moving, np.where(speeding, signed, -signed), 0.0)

    def relative_velocity(self, times: Array) -> Array:
        """Slider's velocity in the body v [m/s] at `times` [s], shape (n,)."""
        back, outward = self._outward(times)
        signed = math.copysign(self.acceleration, self.length)
        speed = np.minimum(outward, np.maximum(self.one_way - outward, 0.0))
        return np.where(back, -signed, signed) * speed

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

    @property
    def stops(self) -> tuple[float, ...]:
        """None: the body does not move."""
        return ()

    def driving_force(self, times: Array) -> Array:
        """Force of the actuator on the slider [N] at `times` [s], shape (n,): m w, which friction
        passes on to the plane."""
        return self.capsule.slider_mass * self.relative_acceleration(times)

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Exact observables at `times` [s], shape (n,), as `line_reference` names them:
        the body does not move, and friction is m w."""
        times = np.asarray(times, dtype=np.float64)
        still = np.zeros_like(times)
        return {
            **dict.fromkeys(("displacement", "velocity", "heading", "sideways"), still),
            "stroke": self.strokes(times),
            "stroke_rate": self.relative_velocity(times),
            **by_support(self.normal_forces(times)),
            "friction_force": self.driving_force(times),
            "driving_force": self.driving_force(times),
        }

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Absolute error [SI] at `times` [s], shape (n,), that parameters and times rounded to
        double, and the arithmetic, may have caused."""
        times = np.asarray(times, dtype=np.float64)
        still, few = np.zeros_like(times), ROUNDINGS * ROUNDOFF
        reach = abs(self.start) + abs(self.length)
        slack = still + normal_force_uncertainty(self.capsule, reach)
        pull = self.capsule.slider_mass * self.acceleration
        return {
            **dict.fromkeys(("displacement", "velocity", "heading", "sideways"), still),
            "stroke": still + few * abs(self.length),
            "stroke_rate": still + few * self.acceleration * self.duration,
            **dict.fromkeys(NORMAL_FORCES, slack),
            "friction_force": still + few * pull,
            "driving_force": still + few * pull,
        }


def slow_return(manoeuvre: LineManoeuvre, fraction: float = 1.0) -> SlowStroke:
    """The slow motion of the slider back to where `manoeuvre` began. Raises ParameterError.
    Chernousko 2020, end of the section on rectilinear motions."""
    return SlowStroke(
        manoeuvre.capsule,
        -manoeuvre.stroke,
        fraction,
        manoeuvre.direction,
        manoeuvre.start + manoeuvre.stroke,
        there_and_back=False,
    )
