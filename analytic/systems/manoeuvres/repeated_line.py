"""Repeated line manoeuvres, with a slow return of the slider after each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.parameters import ParameterError, non_negative
from plumbob.analytic.reference import Array, LinearResponse
from plumbob.analytic.systems.capsule import NORMAL_FORCES, steepest_load
from plumbob.analytic.systems.capsule_motion import MotionKind
from plumbob.analytic.systems.manoeuvres.driving_force import driving_force
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import SNAP, LineManoeuvre
from plumbob.analytic.systems.manoeuvres.line_reference import LineReference
from plumbob.analytic.systems.manoeuvres.slow_motion import SlowStroke, slow_return
from plumbob.analytic.systems.slider_path import SliderPath, concatenate, fixed


@dataclass(frozen=True)
class RepeatedLine(LinearResponse):
    """`count` times `manoeuvre`, each followed by a slow return at `fraction` of f g/mu and by
    `pause` [s] of rest, which can put every start on a grid of steps: the error of a fixed step is
    then `count` times that of one manoeuvre. Raises ParameterError. Chernousko 2020, end of the
    section on rectilinear motions."""

    manoeuvre: LineManoeuvre
    count: int
    fraction: float = 1.0
    pause: float = 0.0
    kind: ClassVar[MotionKind] = "repeated-line"

    def __post_init__(self) -> None:
        if isinstance(self.count, bool) or not isinstance(self.count, int) or self.count < 1:
            raise ParameterError("count", self.count, "a whole number of 1 or more")
        non_negative("pause", self.pause)
        _ = self.returning

    @cached_property
    def returning(self) -> SlowStroke:
        """The slow return after each manoeuvre."""
        return slow_return(self.manoeuvre, self.fraction)

    @property
    def single(self) -> LineManoeuvre:
        """The manoeuvre that is repeated."""
        return self.manoeuvre

    @property
    def sliding_time(self) -> float:
        """Time for which the body slides in one manoeuvre [s]."""
        return self.manoeuvre.t_star

    @cached_property
    def path(self) -> SliderPath:
        """The slider's path in the body over all manoeuvres."""
        there, back = self.manoeuvre.path, self.returning.path
        once = (there, back, fixed(self.manoeuvre.segment.start, self.pause))
        return concatenate(*(self.count * once))

    @property
    def period(self) -> float:
        """Time from the start of one manoeuvre to the start of the next [s]."""
        return self.manoeuvre.t2 + self.returning.duration + self.pause

    @property
    def duration(self) -> float:
        """Time from which body and slider rest [s]."""
        return self.count * self.period

    @property
    def displacement(self) -> float:
        """Body's whole displacement along the line [m]: count times eq. 22."""
        return self.count * self.manoeuvre.displacement

    @property
    def mean_speed(self) -> float:
        """Magnitude of the body's displacement over the time that it takes [m/s]."""
        return abs(self.manoeuvre.displacement) / self.period

    def within(self, times: Array) -> tuple[Array, Array]:
        """Number of whole manoeuvres done at `times` [s], and the time in the present one [s]."""
        times = np.asarray(times, dtype=np.float64)
        done = np.clip(np.floor(times / self.period), 0, self.count - 1)
        return done, np.maximum(times - done * self.period, 0.0)

    def relative_acceleration(self, times: Array) -> Array:
        """Slider's acceleration in the body w [m/s^2] at `times` [s], shape (n,)."""
        _, local = self.within(times * (1.0 + SNAP))
        there = self.manoeuvre.relative_acceleration(local)
        back = self.returning.relative_acceleration(local - self.manoeuvre.t2)
        return np.where(local < self.manoeuvre.t2, there, back)

    def relative_velocity(self, times: Array) -> Array:
        """Slider's velocity in the body v [m/s] at `times` [s], shape (n,)."""
        _, local = self.within(times)
        there = self.manoeuvre.relative_velocity(local)
        back = self.returning.relative_velocity(local - self.manoeuvre.t2)
        return np.where(local < self.manoeuvre.t2, there, back)

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Exact observables at `times` [s], shape (n,), as `line_reference` names them."""
        done, local = self.within(times)
        there = LineReference(self.manoeuvre).observe(local)
        back = dict(self.returning.observe(local - self.manoeuvre.t2))
        back["displacement"] = back["displacement"] + self.manoeuvre.displacement
        back["stroke"] = back["stroke"] + self.manoeuvre.stroke
        early = local < self.manoeuvre.t2
        observed = {name: np.where(early, there[name], back[name]) for name in there}
        observed["friction_force"] = self.friction_force(times)
        observed["driving_force"] = self.driving_force(times)
        observed["displacement"] = observed["displacement"] + done * self.manoeuvre.displacement
        return observed

    def friction_force(self, times: Array) -> Array:
        """Friction [N] on the interval that begins at `times` [s], shape (n,), to within
        round-off."""
        _, local = self.within(times * (1.0 + SNAP))
        sticking = self.manoeuvre.capsule.slider_mass * self.relative_acceleration(times)
        moving = local < self.manoeuvre.t_star
        return np.where(moving, self.manoeuvre.friction_force(local), sticking)

    @property
    def stops(self) -> tuple[float, ...]:
        """When the body comes to rest in each manoeuvre [s]."""
        return tuple(n * self.period + self.manoeuvre.t_star for n in range(self.count))

    def driving_force(self, times: Array) -> Array:
        """Force of the actuator on the slider [N] at `times` [s], shape (n,) (eqs. 3, 9)."""
        friction, slid = self.friction_force(times), self.relative_acceleration(times)
        return driving_force(self.manoeuvre.capsule, friction, slid)

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Absolute error [SI] at `times` [s], shape (n,), that parameters and times rounded to
        double, and the arithmetic, may have caused; it adds up over the manoeuvres."""
        done, local = self.within(times)
        single = LineReference(self.manoeuvre)
        there, back = single.uncertainty(local), self.returning.uncertainty(local)
        at_end = single.uncertainty(np.array([self.manoeuvre.t2]))
        total = {name: there[name] + back[name] for name in there}
        total["displacement"] = total["displacement"] + done * at_end["displacement"]
        # The time of a start after many periods has the round-off of the whole time.
        shift, line, observed = 8 * ROUNDOFF * np.abs(times), self.manoeuvre, self.observe(times)
        fastest = max(line.w1, line.w2, self.returning.acceleration)
        for name, rate in (
            ("displacement", np.abs(observed["velocity"])),
            ("velocity", line.closed.backward + line.closed.braking),
            ("stroke", np.abs(observed["stroke_rate"])),
            ("stroke_rate", fastest),
        ):
            total[name] = total[name] + shift * rate
        slope = steepest_load(line.capsule) * np.abs(observed["stroke_rate"])
        for name in NORMAL_FORCES:
            total[name] = total[name] + shift * slope
        return total
