"""Turn manoeuvres in a row, each from rest: exact, one motion followed and then laid end to end."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from plumbob.analytic.parameters import ParameterError, non_negative
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.capsule_motion import MotionKind
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.analytic.systems.slider_path import SliderPath, concatenate, fixed
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.analytic.systems.three_points.motion import Pose, ThreePointMotion

WHOLE = 1e-12  # how far from whole circles, over their number, the slider's way may be


@dataclass(frozen=True)
class RepeatedTurn:
    """`count` turn manoeuvres alike, the slider held for `pause` [s] after each.

    From the second on a turn begins as the first one did, in the body's axes: so several need a
    slider that goes round whole circles, and a pause in which the residual motion ends. Raises
    ParameterError.
    """

    manoeuvre: TurnManoeuvre
    count: int = 1
    pause: float = 0.0
    kind: ClassVar[MotionKind] = "plane"

    def __post_init__(self) -> None:
        if isinstance(self.count, bool) or not isinstance(self.count, int) or self.count < 1:
            raise ParameterError("count", self.count, "a whole number, 1 or greater")
        object.__setattr__(self, "pause", non_negative("pause", self.pause))
        circles = self.manoeuvre.slider_angle / (2.0 * math.pi)
        if self.count == 1:
            return
        if round(circles) == 0 or abs(circles - round(circles)) > WHOLE * abs(circles):
            need = "whole circles, for more turns than one to be alike"
            raise ParameterError("slider_angle", self.manoeuvre.slider_angle, need)
        if self.period < self.single.rest_time:
            least = self.single.rest_time - 2.0 * self.manoeuvre.half_time
            raise ParameterError("pause", self.pause, f"at least {least:.6g} s, for all to rest")

    @property
    def period(self) -> float:
        """From the start of one turn to that of the next [s]."""
        return 2.0 * self.manoeuvre.half_time + self.pause

    @property
    def duration(self) -> float:
        """Time at which the body rests for good [s]."""
        return (self.count - 1) * self.period + self.single.rest_time

    @property
    def sliding_time(self) -> float:
        """Time from the start of a turn to rest [s]."""
        return self.single.rest_time

    @property
    def capsule(self) -> Capsule:
        """The body that is turned."""
        return self.manoeuvre.capsule

    @cached_property
    def path(self) -> SliderPath:
        """What the slider does in the body, turn after turn."""
        one = self.manoeuvre.path
        if self.count == 1:
            return one
        return concatenate(*(self.count * (one, fixed(one.end, self.pause))))

    @cached_property
    def single(self) -> ThreePointMotion:
        """The exact motion of the first turn, to rest."""
        return three_point_motion(self.manoeuvre.capsule, self.manoeuvre.path)

    @cached_property
    def _gained(self) -> tuple[complex, float]:
        """Shift of C [m] and turn [rad] of one manoeuvre."""
        end = self.single.at(np.array([self.single.rest_time]))
        return complex(*end.position[0]), float(end.heading[0])

    def _within(self, times: Array) -> tuple[Array, Array]:
        """Number of turns done, and time since the last one began [s], shape (n,)."""
        times = np.atleast_1d(np.asarray(times, dtype=np.float64))
        done = np.clip(np.floor(times / self.period), 0, self.count - 1)
        return done, np.maximum(times - done * self.period, 0.0)

    def at(self, times: Array) -> Pose:
        """Pose and velocity of the body at `times` [s], shape (n,)."""
        done, local = self._within(times)
        now, (shift, turn) = self.single.at(local), self._gained
        facing = np.exp(1j * turn * done)
        # shift (1 + e^(i turn) + ...), a geometric series
        base = shift * done if turn == 0.0 else shift * (facing - 1.0) / (np.exp(1j * turn) - 1.0)
        place = base + facing * (now.position @ [1.0, 1j])
        speed = facing * (now.velocity @ [1.0, 1j])
        return Pose(
            np.column_stack([place.real, place.imag]),
            now.heading + turn * done,
            np.column_stack([speed.real, speed.imag]),
            now.angular_velocity,
        )

    @cached_property
    def error(self) -> Pose:
        """Largest error over the whole train: that of one turn, once for each; what headings err by
        carries the places that follow."""
        own, n = self.single.error, self.count
        (shift, _), turned = self._gained, n * float(own.heading[0])
        place = n * (own.position + turned * abs(shift))
        speed = float(np.abs(self.single.at(np.array([self.manoeuvre.half_time])).velocity).max())
        return Pose(place, n * own.heading, own.velocity + turned * speed, own.angular_velocity)

    def slider(self, times: Array) -> Array:
        """Place of the slider relative to C [m], shape (n, 2), at `times` [s], shape (n,)."""
        return self.manoeuvre.path.kinematics(self._within(times)[1])[0]

    def relative_velocity(self, times: Array) -> Array:
        """Its velocity in the body [m/s], shape (n, 2), at `times` [s], shape (n,)."""
        return self.manoeuvre.path.kinematics(self._within(times)[1])[1]
