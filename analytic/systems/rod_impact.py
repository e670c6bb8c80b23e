"""A rod that strikes a rough floor at an angle, with one of its ends.

A uniform rod is at an angle t from the floor; it points forward if t > pi/2. The inverse masses of
its lower end along the floor, across and off it are given by m (a, b, c) = 1 + 3 sin^2 t, -3 sin t
cos t, 1 + 3 cos^2 t (Routh 1905, Dynamics of a System of Rigid Bodies, 187-193). If forces press
the sliding end down, a rod that slides without falling has an impact (Genot and Brogliato 1999,
Eur. J. Mech. A 18, 653).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP, rounded_inputs
from plumbob.analytic.numerics.point_impact import LAWS, PointImpact
from plumbob.analytic.parameters import ParameterError, check_fields
from plumbob.analytic.reference import Array, LinearResponse, Signals

ROD_ROUNDINGS = 16.0  # number of roundings by which the uncertainty changes each parameter
HEIGHT_SAMPLES = 2001  # times after the impact at which the heights of the ends are examined


@dataclass(frozen=True)
class RodImpact(LinearResponse):
    """A rod of `length` [m] and `mass` [kg] at an `angle` [rad] from the floor. Its lower end is at
    first at a `height` [m]; the rod falls under `gravity` [m/s^2] and moves with a `speed` [m/s]
    along the floor. It strikes the floor with a coefficient of `friction`, and of `restitution` by
    a `law` of LAWS. Raises ParameterError.

    >>> RodImpact(1.0, 1.0, 1.1, 0.5, -2.0, 0.3, 0.5, "newton", 9.81).impact.outcome
    'slides'
    """

    length: float
    mass: float
    angle: float
    height: float
    speed: float
    friction: float
    restitution: float
    law: str
    gravity: float

    def __post_init__(self) -> None:
        impact_fields = "friction", "restitution", "law"
        check_fields(self, ("length", "mass", "angle", "gravity"), ("height",), impact_fields)
        if self.angle > 3.1415:
            raise ParameterError("angle", self.angle, "at most 3.1415")
        impact_without_fall = self.impact.jams and self.law != LAWS[0]
        # Newton's law returns a part of the falling speed, which is 0 without a height.
        if not self.height and not impact_without_fall:
            need = "greater than 0, or there is no rebound"
            raise ParameterError("height", self.height, need)

    @property
    def weights(self) -> tuple[float, float, float]:
        """Inverse masses a, b and c [1/kg]."""
        sine = math.sin(self.angle)
        cosine = math.cos(self.angle)
        inverse = 1.0 / self.mass
        return (
            inverse * (1 + 3 * sine**2),
            -3 * inverse * sine * cosine,
            inverse * (1 + 3 * cosine**2),
        )

    @cached_property
    def impact(self) -> PointImpact:
        """The impact of the rod's lower end."""
        speeds = self.speed, -self.gravity * self.fall
        return PointImpact(self.weights, self.friction, self.restitution, self.law, *speeds)

    @property
    def fall(self) -> float:
        """Time of the impact [s]."""
        return math.sqrt(2.0 * self.height / self.gravity)

    def _after_impact(self, times: Array) -> Signals:
        """Returns the observables at `times` [s], shape (n,), if there is no second impact."""
        _, up, along = self.impact.impulses
        sine = math.sin(self.angle)
        cosine = math.cos(self.angle)
        # Time since the impact divided by the mass: times an impulse, it is a displacement.
        elapsed = np.maximum(times - self.fall, 0.0) / self.mass
        start = self.height + self.length / 2.0 * sine
        return {
            "x": self.speed * times + along * elapsed,
            "z": start - self.gravity * times**2 / 2.0 + up * elapsed,
            "angle": self.angle + 6.0 * (along * sine - up * cosine) / self.length * elapsed,
        }

    @cached_property
    def until(self) -> float:
        """A time [s] shortly before an end of the rod strikes the floor for a second time."""
        apex = self.fall + self.impact.impulses[1] / self.mass / self.gravity
        # At the time `latest` the rod would be below the floor.
        latest = 2.0 * apex + math.sqrt(8.0 * self.length / self.gravity)
        times = np.linspace(self.fall, latest, HEIGHT_SAMPLES)
        flight = self._after_impact(times)
        is_above = flight["z"] > self.length / 2.0 * np.abs(np.sin(flight["angle"]))
        return float(times[int(np.argmin(is_above[1:]))])

    def observe(self, times: Array) -> Signals:
        """Exact position of the centre x and z [m] and the angle [rad] at `times` [s], shape (n,).
        Raises ParameterError for times beyond `until`."""
        last = float(np.max(times, initial=0.0))
        if last > self.until:
            raise ParameterError("times", last, f"at most {self.until:.6g} s: it strikes again")
        return self._after_impact(times)

    def uncertainty(self, times: Array) -> Signals:
        """Bound on the error of each observable, shape (n,), by the rounding of each parameter and
        of lengths."""
        errors = rounded_inputs(self, lambda rod: rod._after_impact(times), ROD_ROUNDINGS)
        rounding = ULP * (self.length + abs(self.speed) * times)
        return {name: error + rounding for name, error in errors.items()}
