"""Repeated turn manoeuvres, each from rest: copies of one exact motion, joined end to end."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from plumbob.analytic.parameters import ParameterError, counting, non_negative
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.capsule_motion import MotionKind
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.analytic.systems.slider_path import SliderPath, concatenate, fixed
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.analytic.systems.three_points.motion import CapsulePose, ThreePointMotion

WHOLE_CIRCLES = 1e-12  # largest relative difference of the slider's angle from whole circles


@dataclass(frozen=True)
class RepeatedTurn:
    """`count` equal turn manoeuvres, with the slider fixed for `pause` [s] after each.

    Every turn begins like the first one in body axes. So several turns need a slider that moves
    through whole circles, and a pause in which the residual motion ends. Raises ParameterError.
    """

    manoeuvre: TurnManoeuvre
    count: int = 1
    pause: float = 0.0
    kind: ClassVar[MotionKind] = "plane"

    def __post_init__(self) -> None:
        counting("count", self.count)
        non_negative("pause", self.pause)
        if self.count == 1:
            return
        circles = self.manoeuvre.slider_angle / (2.0 * math.pi)
        difference = abs(circles - round(circles))
        if round(circles) == 0 or difference > WHOLE_CIRCLES * abs(circles):
            need = "whole circles, for several turns to be equal"
            raise ParameterError("slider_angle", self.manoeuvre.slider_angle, need)
        if self.period < self.single.rest_time:
            least = self.single.rest_time - 2.0 * self.manoeuvre.half_time
            need = f"at least {least:.6g} s, for the body to come to rest"
            raise ParameterError("pause", self.pause, need)

    @property
    def period(self) -> float:
        """Time from the start of one turn to the start of the next [s]."""
        return 2.0 * self.manoeuvre.half_time + self.pause

    @property
    def duration(self) -> float:
        """Time from the start to the body's final rest [s]."""
        return (self.count - 1) * self.period + self.single.rest_time

    @property
    def capsule(self) -> Capsule:
        """The body that turns."""
        return self.manoeuvre.capsule

    @cached_property
    def path(self) -> SliderPath:
        """The slider's path in the body over all turns."""
        turn = self.manoeuvre.path
        if self.count == 1:
            return turn
        return concatenate(*(self.count * (turn, fixed(turn.end, self.pause))))

    @cached_property
    def single(self) -> ThreePointMotion:
        """The exact motion of the first turn, to rest. Raises ParameterError if friction is too
        small to determine the time of rest."""
        least = self.manoeuvre.least_friction
        friction = self.capsule.friction
        if friction < least:
            need = f"greater than {least:.2g}, for a double to show what friction does in this turn"
            raise ParameterError("friction", friction, need)
        return three_point_motion(self.manoeuvre.capsule, self.manoeuvre.path)

    @cached_property
    def _change_per_turn(self) -> tuple[complex, float]:
        """Displacement of C [m], complex, and turn of the body [rad] by one manoeuvre."""
        end = self.single.at(np.array([self.single.rest_time]))
        return complex(*end.position[0]), float(end.heading[0])

    def _local_times(self, times: Array) -> tuple[Array, Array]:
        """Returns the number of complete turns at `times` [s], and the time since the present turn
        began [s], shape (n,) each."""
        times = np.atleast_1d(np.asarray(times, dtype=np.float64))
        turns = np.clip(np.floor(times / self.period), 0, self.count - 1)
        return turns, np.maximum(times - turns * self.period, 0.0)

    def at(self, times: Array) -> CapsulePose:
        """Returns pose and velocity of the body at `times` [s], shape (n,)."""
        turns, local = self._local_times(times)
        pose = self.single.at(local)
        shift, angle = self._change_per_turn
        facing = np.exp(1j * angle * turns)
        if angle == 0.0:
            base = shift * turns
        else:  # the sum shift (1 + e^(i angle) + ...) is a geometric series
            base = shift * (facing - 1.0) / (np.exp(1j * angle) - 1.0)
        place = base + facing * (pose.position @ [1.0, 1j])
        velocity = facing * (pose.velocity @ [1.0, 1j])
        return CapsulePose(
            np.column_stack([place.real, place.imag]),
            pose.heading + angle * turns,
            np.column_stack([velocity.real, velocity.imag]),
            pose.angular_velocity,
        )

    @cached_property
    def error(self) -> CapsulePose:
        """Bound on the error of the pose over all turns. Each turn adds the error of one turn, and
        an error of heading rotates all later displacements."""
        single = self.single.error
        n = self.count
        shift, _ = self._change_per_turn
        heading_error = n * float(single.heading[0])
        fastest = self.single.at(np.array([self.manoeuvre.half_time]))
        speed = float(np.abs(fastest.velocity).max())
        return CapsulePose(
            n * (single.position + heading_error * abs(shift)),
            n * single.heading,
            single.velocity + heading_error * speed,
            single.angular_velocity,
        )
