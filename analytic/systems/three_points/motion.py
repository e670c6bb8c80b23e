"""The motion of a body on three Coulomb points as a function of time: pose, velocity and events."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise
from typing import ClassVar

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.capsule_motion import MotionKind, SingleMotion
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.analytic.systems.three_points.equations import Complex, Mechanics
from plumbob.analytic.systems.three_points.smooth_segment import (
    Mode,
    SmoothSegment,
    velocity_of_c,
)

Segments = tuple[SmoothSegment, ...]
ROUNDINGS = 32 * ROUNDOFF  # relative rounding of a sum over some tens of segments


@dataclass(frozen=True)
class Event:
    """The time [s] at which a mode begins. `support` (0, 1, 2) is the support at rest in a pivot,
    or the support that has just slipped from rest while the others slide, else -1."""

    time: float
    mode: Mode
    support: int


@dataclass(frozen=True)
class Pose:
    """Position of C on the ground [m] and velocity of C [m/s], shape (n, 2); heading psi [rad] and
    angular velocity [rad/s], shape (n,)."""

    position: Array
    heading: Array
    velocity: Array
    angular_velocity: Array


@dataclass(frozen=True)
class ThreePointMotion(SingleMotion):
    """An exact motion, in segments of one mode each, and the events between the segments.

    `integrate` computes the segments. `coarser` computes the same motion with fewer nodes and a
    larger tolerance, for `error`.
    """

    capsule: Capsule
    path: SliderPath
    body: Mechanics
    integrate: Callable[[], Segments]
    coarser: Callable[[], ThreePointMotion]
    kind: ClassVar[MotionKind] = "plane"

    @cached_property
    def segments(self) -> Segments:
        """The segments in the order of time."""
        return self.integrate()

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """The changes of mode, and the times at which a support slips from rest, in the order of
        time."""
        events: list[Event] = []
        for begin, segment in zip(self.begins.tolist(), self.segments, strict=True):
            mode_continues = bool(events) and segment.mode == events[-1].mode
            support_slips = segment.mode == "slide" and segment.support >= 0
            if support_slips or not mode_continues:
                events.append(Event(begin, segment.mode, segment.support))
        return tuple(events)

    @property
    def sliding_time(self) -> float:
        """Time from the start to the final rest [s], as `rest_time`."""
        return self.rest_time

    @cached_property
    def begins(self) -> Array:
        """Start of each segment [s], shape (segments,)."""
        piece_starts = self.path.breakpoints
        return np.array([piece_starts[s.interval.number] + s.start for s in self.segments])

    @property
    def rest_time(self) -> float:
        """Time of the final rest [s]; infinite if the motion does not end in rest."""
        last = self.events[-1]
        return last.time if last.mode == "rest" else np.inf

    @cached_property
    def error(self) -> Pose:
        """Largest difference from the less accurate motion `coarser`, over the whole motion, plus
        round-off. Its parts have the shapes (1, 2) and (1,). The difference is almost entirely the
        error of `coarser`."""
        edges = np.append(self.begins, self.begins[-1])
        times = np.unique(np.concatenate([np.linspace(a, b, 5) for a, b in pairwise(edges)]))
        poses = self.at(times)
        coarser_poses = self.coarser().at(times)
        bounds = []
        for field in fields(Pose):
            values = getattr(poses, field.name)
            difference = np.abs(values - getattr(coarser_poses, field.name))
            size = float(np.abs(values).max())
            bounds.append(difference.max(axis=0, keepdims=True) + ROUNDINGS * size)
        return Pose(*bounds)

    def at(self, times: Array) -> Pose:
        """Returns pose and velocity of the body at `times` [s], shape (n,)."""
        times = np.atleast_1d(np.asarray(times, dtype=np.float64))
        numbers = np.clip(np.searchsorted(self.begins, times, side="right") - 1, 0, None)
        states = np.empty((times.size, 7))
        for number in np.unique(numbers):
            selected = numbers == number
            segment = self.segments[number]
            local = times[selected] - self.path.breakpoints[segment.interval.number]
            states[selected] = segment.states(np.clip(local, segment.start, segment.end))
        slider: Complex = self.path.places(times) @ np.array([1.0, 1j])
        omega, _, heading = states[:, 2:5].T
        velocity = velocity_of_c(self.body, slider, states)
        velocity *= np.exp(1j * heading)
        velocities = np.column_stack([velocity.real, velocity.imag])
        return Pose(states[:, 5:], heading, velocities, omega)
