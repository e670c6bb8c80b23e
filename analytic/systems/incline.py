"""A cube on an inclined plane with Coulomb friction: it rests, slides, stops, or slides back.

Along the slope x'' = g (sin(theta) - f cos(theta) sign(x')). A cube at rest stays there if
tan(theta) <= f (Coulomb 1785). A cube with f < 1 does not tip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP, rounded_inputs
from plumbob.analytic.parameters import ParameterError, check_fields
from plumbob.analytic.reference import Array, LinearResponse, Signals

ROUNDINGS = 8.0  # roundings of each parameter in the uncertainty


@dataclass(frozen=True)
class Incline(LinearResponse):
    """A cube of edge `size` [m] and `mass` [kg] on a plane of inclination `slope` [rad] with a
    coefficient of `friction` below 1, under `gravity` [m/s^2]. It starts with a `speed` [m/s],
    positive downhill. Downhill is at the angle `heading` [rad] from an engine's first axis in the
    plane. Raises ParameterError.

    >>> Incline(0.0, 0.5, 1.0, 0.1, 3.0, 9.0).rest_time
    0.6666666666666666
    """

    slope: float
    friction: float
    mass: float
    size: float
    speed: float
    gravity: float
    heading: float = 0.0

    def __post_init__(self) -> None:
        check_fields(self, ("mass", "size", "gravity"), ("slope", "friction"))
        if self.slope > 1.5:
            raise ParameterError("slope", self.slope, "at most 1.5 rad")
        if self.friction >= 1.0:
            raise ParameterError("friction", self.friction, "less than 1, or the cube may tip")

    @property
    def pull(self) -> float:
        """Component of gravity along the slope [m/s^2]."""
        return self.gravity * math.sin(self.slope)

    @property
    def press(self) -> float:
        """Component of gravity into the slope [m/s^2]."""
        return self.gravity * math.cos(self.slope)

    @property
    def holds(self) -> bool:
        """True if friction holds the cube at rest."""
        return math.tan(self.slope) <= self.friction

    def acceleration(self, sense: float) -> float:
        """Returns the acceleration [m/s^2] of a cube that slides downhill (`sense` 1) or uphill
        (-1)."""
        return self.pull - sense * self.friction * self.press

    @property
    def stop_time(self) -> float:
        """Time at which the cube stops for the first time [s]; infinite if it never does."""
        rate = self.acceleration(float(np.sign(self.speed)))
        if not self.speed:
            return 0.0
        return -self.speed / rate if self.speed * rate < 0.0 else math.inf

    @property
    def rest_time(self) -> float:
        """Time from which the cube is at rest [s]; infinite if it never is."""
        return self.stop_time if self.holds else math.inf

    @property
    def stop_place(self) -> float:
        """Position at which the cube stops for the first time [m]; NaN if it never does."""
        return self.speed * self.stop_time / 2.0 if math.isfinite(self.stop_time) else math.nan

    def observe(self, times: Array) -> Signals:
        """Exact position x [m], positive downhill, and speed [m/s] at `times` [s], shape (n,)."""
        first = self.acceleration(float(np.sign(self.speed)))
        second = 0.0 if self.holds else self.acceleration(1.0)
        stop = self.stop_time
        until_stop = np.minimum(times, stop)
        after_stop = np.maximum(times - stop, 0.0)
        has_stopped = times >= stop
        stop_place = np.where(has_stopped, np.nan_to_num(self.stop_place), 0.0)
        x = until_stop * (self.speed + until_stop * first / 2.0)
        speed = self.speed + until_stop * first
        return {
            "x": stop_place + np.where(has_stopped, 0.0, x) + second * after_stop**2 / 2.0,
            "speed": np.where(has_stopped, 0.0, speed) + second * after_stop,
        }

    def uncertainty(self, times: Array) -> Signals:
        """Bound on the error of each observable, shape (n,), by the rounding of each parameter and
        of a position."""
        errors = rounded_inputs(self, lambda cube: cube.observe(times), ROUNDINGS)
        return {**errors, "x": errors["x"] + ULP * self.size}
