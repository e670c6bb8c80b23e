"""Bodies and joints of a capsule in pymunk, seen from above or from the side, and their start."""

from __future__ import annotations

import cmath
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import pymunk

from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.pymunk.simulation import vector
from plumbob.engines.trajectory import ByName
from plumbob.models.tripod_capsule.observed import ChainPose

SETTLING_ITERATIONS = 1000  # iterations that find the impulses at the start
NO_TURNING = float("inf")  # moment of inertia of a body that cannot turn


@dataclass(frozen=True)
class Assembly:
    """Bodies and the slider's joint of a capsule; complex numbers are x + iy."""

    space: pymunk.Space
    body: pymunk.Body  # its origin is the body's centre of mass, not C
    slider: pymunk.Body
    joint: pymunk.PivotJoint  # joint between `body` and `slider`
    start: complex  # place of the slider at the start, from C, in the axes of `body` [m]
    line: complex = 1.0 + 0.0j  # direction of the slider's line in the axes of `body`
    centre: complex = 0j  # place of C in the axes of `body` [m]

    @property
    def momentum(self) -> complex:
        """The momentum of all moving bodies [kg m/s]."""
        return sum((part.mass * complex(*part.velocity) for part in self.space.bodies), 0j)

    @property
    def motion(self) -> tuple[complex, complex, complex, complex]:
        """Place [m] and velocity [m/s] of C in the world, then place and velocity of the slider
        relative to C in the axes of the body. Velocities belong to the time half a step after the
        positions."""
        body = self.body
        slider = self.slider
        spin = 1j * self.body.angular_velocity
        turned = cmath.exp(1j * body.angle)
        later = cmath.exp(0.5 * self.space.current_time_step * spin)
        arm = turned * self.centre
        place = complex(*body.position) + arm
        velocity = complex(*body.velocity) + spin * later * arm
        inside = complex(*slider.position) - place
        sliding = complex(*slider.velocity) - velocity - spin * later * inside
        return place, velocity, inside / turned, sliding / (turned * later)

    @property
    def pose(self) -> ChainPose:
        """The pose as engines of rigid bodies give it."""
        place, velocity, inside, sliding = self.motion
        slid = (inside - self.start) / self.line
        pace = sliding / self.line
        heading = self.body.angle
        rate = self.body.angular_velocity
        return ChainPose(place, velocity, heading, rate, slid.real, pace.real)


@dataclass(frozen=True)
class View:
    """A capsule as seen from above or from the side."""

    assembly: Assembly
    shown: Callable[[], ByName]  # returns the observables of the pose
    loads: Callable[[], Iterable[float]]  # returns the normal forces N_i [N]
    set_limits: Callable[[complex], None] = lambda place: None
    """Place x + iy of the slider from C, in the axes of the body [m] -> nothing: sets the friction
    limits. A view with contacts needs none: contacts have normal forces."""


def slider_start_speed(setup: CapsuleSetup) -> float:
    """The speed of the slider on its line at the start [m/s]."""
    velocity = setup.relative_velocity
    return 0.0 if velocity is None else float(velocity(np.zeros(1))[0])


def pin_joint(body: pymunk.Body, part: pymunk.Body, anchor: complex) -> pymunk.PivotJoint:
    """A joint that keeps the centre of `part` at `anchor` [m, axes of `body`], and closes its
    opening in every step."""
    joint = pymunk.PivotJoint(body, part, vector(anchor), (0.0, 0.0))
    joint.error_bias = 0.0
    return joint


def friction_joint(
    space: pymunk.Space, part: pymunk.Body, anchor: complex
) -> pymunk.PivotJoint:
    """A joint that brings the point `anchor` of `part` [m, axes of `part`] to rest wherever the
    point is. With a largest force the joint acts as friction."""
    joint = pymunk.PivotJoint(part, space.static_body, vector(anchor), (0.0, 0.0))
    joint.max_bias = 0.0
    return joint


def place_part(
    setup: CapsuleSetup,
    part: pymunk.Body,
    anchor: complex,
    centre_of_mass: complex,
    step: float,
) -> None:
    """Puts `part` at its start: pinned at `anchor` to a body with this `centre_of_mass`, both
    relative to C [m, axes of the body].

    A joint that closes in one step is open by as much as the step before has opened it. If the
    joint started closed, its first impulse would be too large."""
    turned = cmath.exp(1j * setup.heading)
    turn = 1j * step * setup.heading_rate
    opening = cmath.exp(-turn) * (1 + turn) - 1
    part.position = vector(turned * (anchor + opening * (anchor - centre_of_mass)))
    part.velocity = vector(
        turned * (complex(*setup.velocity) + (turn - opening) / step * anchor)
    )
