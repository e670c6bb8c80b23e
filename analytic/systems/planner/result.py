"""A plan: its manoeuvres in order, the slider's path, and the pose that it reaches."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.capsule_motion import MotionKind
from plumbob.analytic.systems.planner.manoeuvre import Manoeuvre
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, Limits, RestPose
from plumbob.analytic.systems.planner.tracks import (
    ArcName,
    Ends,
    LineSegment,
    Pair,
    Track,
    curve,
)
from plumbob.analytic.systems.slider_path import SliderPath, concatenate, fixed
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.analytic.systems.three_points.motion import ThreePointMotion

TrackName = Literal["free", "curve"]


@dataclass(frozen=True)
class Plan:
    """Manoeuvres in order that carry body and slider from `start` to `goal`.

    The open-loop input of an engine are the positions and velocities of `path`, in body axes.
    """

    capsule: Capsule
    start: RestPose
    goal: RestPose
    limits: Limits
    track: TrackName
    manoeuvres: tuple[Manoeuvre, ...] = field(repr=False)
    # supports towards which the curve's segments lie, if `segments` is None
    legs: Pair = (1, 2)
    arc: ArcName | Ends = "shorter"
    segments: tuple[LineSegment, ...] | None = None
    kind: ClassVar[MotionKind] = "plane"
    count: ClassVar[int] = 1
    period: ClassVar[float] = math.inf

    @cached_property
    def rails(self) -> Track:
        """The track on which the slider may move."""
        if self.track == "free":
            return Track(self.capsule, self.limits)
        return curve(self.capsule, self.limits, self.legs, self.arc, self.segments)

    @cached_property
    def path(self) -> SliderPath:
        """The slider's path relative to the body, from the first manoeuvre to the last."""
        if not self.manoeuvres:
            return fixed(self.start.slider)
        return concatenate(*(manoeuvre.path for manoeuvre in self.manoeuvres))

    @property
    def single(self) -> ThreePointMotion:
        """The exact motion of the whole plan, with its events: a plan is not repeated."""
        return self.motion

    @property
    def duration(self) -> float:
        """Total time of the manoeuvres [s]."""
        return self.path.duration

    @property
    def turns(self) -> int:
        """Number of turn manoeuvres."""
        return sum(manoeuvre.kind == "turn" for manoeuvre in self.manoeuvres)

    @property
    def lines(self) -> int:
        """Number of line manoeuvres."""
        return sum(manoeuvre.kind == "line" for manoeuvre in self.manoeuvres)

    @property
    def ends(self) -> Array:
        """End of each manoeuvre [s], shape (n,). Body and slider then rest."""
        return np.array([m.start + m.duration for m in self.manoeuvres])

    @cached_property
    def motion(self) -> ThreePointMotion:
        """The exact motion of the whole plan, in the axes of its start pose."""
        return three_point_motion(self.capsule, self.path)

    @property
    def reached(self) -> RestPose:
        """The pose at the end of the exact motion."""
        end = self.motion.at(np.array([max(self.duration, self.motion.rest_time)]))
        facing = cmath.rect(1.0, self.start.heading)
        place = self.start.place + complex(*end.position[0]) * facing
        heading = self.start.heading + float(end.heading[0])
        return RestPose(place.real, place.imag, heading, self.path.end)

    @property
    def error(self) -> tuple[float, float]:
        """Distance [m] and angle [rad] between the reached pose and `goal`."""
        return pose_error(self.reached, self.goal)


def pose_error(reached: RestPose, goal: RestPose) -> tuple[float, float]:
    """Returns distance [m] and angle [rad] between two poses, modulo whole turns."""
    angle = math.remainder(reached.heading - goal.heading, FULL_CIRCLE)
    return abs(reached.place - goal.place), abs(angle)
