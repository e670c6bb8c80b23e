"""Set-up of a capsule scene for an engine: the body, its start, the slider's motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.reference import Array, LinearResponse, Reference, Signals
from plumbob.analytic.systems.capsule import Capsule, Point


@dataclass(frozen=True)
class CapsuleSetup:
    """A start and the imposed motion, the same for every engine.

    Body axes have their origin at C and are turned by the heading; the world's coincide with them
    but for the heading at the start. Signed quantities are positive along `direction`.
    """

    capsule: Capsule
    slider: Point = (0.0, 0.0)  # place of Q at the start, body axes [m]
    direction: float = 0.0  # of the slider's track and of what is measured, body axes [rad]
    heading: float = 0.0  # of the body in the world at the start [rad]
    velocity: Point = (0.0, 0.0)  # of C at the start, body axes [m/s]
    heading_rate: float = 0.0  # at the start [rad/s]
    pull: float = 0.0  # of tilted gravity along `direction` [m/s^2]
    press: float = 0.0  # of gravity onto the plane [m/s^2]
    relative_velocity: Callable[[Array], Array] | None = None
    """Imposed velocity of the slider in the body along `direction` [m/s] at times [s], shape (n,);
    None where it does not move, or not along one line."""
    in_plane: bool = False
    """Whether x, y, heading and their rates are observed, not quantities along one line."""
    plane_velocity: Callable[[Array], Array] | None = None
    """Imposed velocity of the slider in the body [m/s], body axes, shape (n, 2), at times [s],
    shape (n,); None where it does not move, or along one line only."""
    plane_place: Callable[[Array], Array] | None = None
    """Its place relative to C [m], body axes, shape (n, 2), at the same times."""

    @property
    def tracks(self) -> tuple[tuple[float, float], ...]:
        """The directions along which the slider is driven, body axes: its line, or both axes of the
        body; none where it does not move."""
        if self.relative_velocity is not None:
            return ((math.cos(self.direction), math.sin(self.direction)),)
        return () if self.plane_velocity is None else ((1.0, 0.0), (0.0, 1.0))

    def slider_velocity(self, times: Array) -> Array:
        """The imposed velocity of a slider that moves along its tracks [m/s] at times [s], shape
        (n,): shape (n, tracks)."""
        if self.relative_velocity is not None:
            return np.asarray(self.relative_velocity(times))[:, None]
        assert self.plane_velocity is not None
        return self.plane_velocity(times)


@dataclass(frozen=True)
class InWorld(LinearResponse):
    """A motion in the axes of its start, its heading in the world: an engine that leaves the
    `heading` [rad] of the start out has every other observable right."""

    own: Reference  # in the axes of the start
    heading: float

    @property
    def closed_form(self) -> Any:
        """None where the motion has none."""
        return getattr(self.own, "closed_form", self.own)

    def observe(self, times: Array) -> Signals:
        """Exact observables at `times` [s], shape (n,)."""
        observed = self.own.observe(times)
        return {**observed, "heading": self.heading + observed["heading"]}

    def uncertainty(self, times: Array) -> Signals:
        """That of the motion; of the heading, with the start's rounding and the sum's."""
        known = self.own.uncertainty(times)
        facing = self.observe(times)["heading"]
        rounding = ROUNDOFF * (abs(self.heading) + np.abs(facing)) if self.heading else 0.0
        return {**known, "heading": known["heading"] + rounding}


@dataclass(frozen=True)
class CapsuleProblem:
    """A motion of the capsule, its reference, and its set-up for an engine."""

    motion: Any  # see `capsule_motion`
    """Of analytic: LineManoeuvre, SlowStroke, TiltedHold, RepeatedLine; in the plane
    ResidualMotion, ThreePointMotion (coasting), RepeatedTurn, Plan. `motion.kind` names it."""
    reference: Reference  # in the axes of the start
    setup: CapsuleSetup

    @property
    def in_world(self) -> InWorld:
        """The reference, its heading in the world."""
        return InWorld(self.reference, self.setup.heading)

    @property
    def slider_ends(self) -> Array:
        """The ends of the slider's line relative to C [m], shape (2, 2): its place, twice, where
        it stays there."""
        if self.setup.relative_velocity is None:
            return np.array([self.setup.slider] * 2)
        return np.array(self.motion.single.ends)

    def slider_places(self, count: int) -> Array:
        """Places of the slider relative to C [m], shape (n, 2), among which are those farthest out:
        the ends of its line, or `count` on its way in the plane."""
        if self.setup.plane_velocity is None:
            return self.slider_ends
        path = self.motion.single.path
        return np.asarray(path.kinematics(np.linspace(0.0, path.duration, count))[0])
