"""Set-up of a capsule scene for an engine: the body, its start and the slider's motion."""

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
    """A start and an imposed motion, the same for every engine.

    Body axes have their origin at C and are turned by the heading. At the start, C is the world's
    origin. Signed quantities are positive along `direction`.
    """

    capsule: Capsule
    slider: Point = (0.0, 0.0)  # position of Q at the start, body axes [m]
    # direction of the slider's track and of observables, body axes [rad]
    direction: float = 0.0
    heading: float = 0.0  # heading of the body in the world at the start [rad]
    velocity: Point = (0.0, 0.0)  # velocity of C at the start, body axes [m/s]
    heading_rate: float = 0.0  # angular velocity at the start [rad/s]
    pull: float = 0.0  # component of gravity along `direction` [m/s^2]
    press: float = 0.0  # component of gravity into the plane [m/s^2]
    relative_velocity: Callable[[Array], Array] | None = None
    """Imposed velocity of the slider in the body along `direction` [m/s] at times [s], shape (n,).
    None if the slider does not move along one line."""
    in_plane: bool = False
    """True if x, y, heading and their rates are observed; False for quantities along one line."""
    plane_velocity: Callable[[Array], Array] | None = None
    """Imposed velocity of the slider in the body [m/s], body axes, shape (n, 2), at times [s],
    shape (n,). None if the slider does not move, or moves along one line."""
    plane_place: Callable[[Array], Array] | None = None
    """Position of the slider relative to C [m], body axes, shape (n, 2), at times [s], shape (n,).
    None if `plane_velocity` is."""

    @property
    def tracks(self) -> tuple[tuple[float, float], ...]:
        """The directions along which the slider is driven, body axes: its line, or both axes of the
        body. Empty if it does not move."""
        if self.relative_velocity is not None:
            return ((math.cos(self.direction), math.sin(self.direction)),)
        return () if self.plane_velocity is None else ((1.0, 0.0), (0.0, 1.0))

    def slider_velocity(self, times: Array) -> Array:
        """Returns the imposed velocity of a moving slider along its tracks [m/s] at times [s],
        shape (n,): shape (n, tracks)."""
        if self.relative_velocity is not None:
            return np.asarray(self.relative_velocity(times))[:, None]
        assert self.plane_velocity is not None
        return self.plane_velocity(times)


@dataclass(frozen=True)
class InWorld(LinearResponse):
    """A motion in the axes of its start, but with its heading in the world. An engine that leaves
    out the initial `heading` [rad] then has an error in the heading alone."""

    in_start_axes: Reference  # the motion in the axes of its start
    heading: float

    @property
    def closed_form(self) -> Any:
        """The closed form of the motion; None if it has none."""
        return getattr(self.in_start_axes, "closed_form", self.in_start_axes)

    def observe(self, times: Array) -> Signals:
        """Exact observables at `times` [s], shape (n,)."""
        observed = self.in_start_axes.observe(times)
        return {**observed, "heading": self.heading + observed["heading"]}

    def uncertainty(self, times: Array) -> Signals:
        """Bound on the error of each observable at `times` [s], shape (n,). The heading's bound
        includes the rounding of the initial heading and of the sum."""
        errors = self.in_start_axes.uncertainty(times)
        heading = self.observe(times)["heading"]
        rounding = ROUNDOFF * (abs(self.heading) + np.abs(heading)) if self.heading else 0.0
        return {**errors, "heading": errors["heading"] + rounding}


@dataclass(frozen=True)
class CapsuleProblem:
    """A motion of the capsule, its reference, and its set-up for an engine."""

    motion: Any  # a motion as described in `capsule_motion`
    """Along a line: LineManoeuvre, SlowStroke, TiltedHold, RepeatedLine. In the plane:
    ResidualMotion, ThreePointMotion (coasting), RepeatedTurn, Plan. `motion.kind` names the
    kind."""
    reference: Reference  # the observables in the axes of the start
    setup: CapsuleSetup

    @property
    def in_world(self) -> InWorld:
        """The reference with its heading in the world."""
        return InWorld(self.reference, self.setup.heading)

    @property
    def slider_ends(self) -> Array:
        """The ends of the slider's line relative to C [m], shape (2, 2). If the slider does not
        move along a line, both are its initial place."""
        if self.setup.relative_velocity is None:
            return np.array([self.setup.slider] * 2)
        return np.array(self.motion.single.ends)

    def slider_places(self, count: int) -> Array:
        """Returns places of the slider relative to C [m], shape (n, 2), that include the farthest
        ones: the ends of its line, or `count` places on its path in the plane."""
        if self.setup.plane_velocity is None:
            return self.slider_ends
        path = self.motion.single.path
        return np.asarray(path.kinematics(np.linspace(0.0, path.duration, count))[0])
