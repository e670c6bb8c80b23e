"""Bodies and joints of a capsule in pymunk, for either view: how they start and what they carry."""

from __future__ import annotations

import cmath
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import pymunk

from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.pymunk.simulation import vector
from plumbob.engines.trajectory import ByName
from plumbob.models.tripod_capsule.observed import Pose

SETTLING_ITERATIONS = 1000  # of the solver, which starts without impulses of a step before
NO_TURNING = float("inf")  # moment of inertia of a body that does not turn


@dataclass(frozen=True)
class Assembly:
    """Bodies and the slider's joint of a capsule; complex numbers are x + iy."""

    space: pymunk.Space
    body: pymunk.Body  # its origin is its own centre of mass, not C
    slider: pymunk.Body
    joint: pymunk.PivotJoint  # of `body` and `slider`
    start: complex  # of the slider, from C in axes of `body` [m]
    line: complex = 1.0 + 0.0j  # direction of the slider's line, in these axes
    centre: complex = 0j  # C in these axes [m]

    @property
    def momentum(self) -> complex:
        """Of all that moves [kg m/s]."""
        return sum((part.mass * complex(*part.velocity) for part in self.space.bodies), 0j)

    @property
    def motion(self) -> tuple[complex, complex, complex, complex]:
        """Place [m] and velocity [m/s] of C in the world, and of the slider from C in the body:
        velocities belong to half a step after positions."""
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
    def pose(self) -> Pose:
        """As rigid-body engines tell it."""
        place, velocity, inside, sliding = self.motion
        slid = (inside - self.start) / self.line
        pace = sliding / self.line
        heading = self.body.angle
        rate = self.body.angular_velocity
        return Pose(place, velocity, heading, rate, slid.real, pace.real)


@dataclass(frozen=True)
class View:
    """A capsule as seen from above or from the side."""

    assembly: Assembly
    shown: Callable[[], ByName]  # the observables that its pose shows
    loads: Callable[[], Iterable[float]]  # N_i [N]
    set_limits: Callable[[complex], None] = lambda place: None
    """Sets the friction limits for a slider at x + iy from C [m, axes of the body]; contacts have
    their own normal forces."""


def begun(setup: CapsuleSetup) -> float:
    """Speed of the slider on its line at the start [m/s]."""
    velocity = setup.relative_velocity
    return 0.0 if velocity is None else float(velocity(np.zeros(1))[0])


def pin_joint(body: pymunk.Body, part: pymunk.Body, anchor: complex) -> pymunk.PivotJoint:
    """Joint that keeps `part` at `anchor` [m, axes of `body`], closed in every step."""
    joint = pymunk.PivotJoint(body, part, vector(anchor), (0.0, 0.0))
    joint.error_bias = 0.0
    return joint


def friction_joint(
    space: pymunk.Space, part: pymunk.Body, anchor: complex
) -> pymunk.PivotJoint:
    """Joint that brings the point `anchor` [m, axes of `part`] to rest, wherever it is: friction,
    once its largest force is set."""
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
    """Put `part` at its start: pinned at `anchor` to a body with this `centre_of_mass`, both from C
    [m, body axes].

    A joint that closes in one step is open by what the step before opened; if it started closed,
    its first impulse would be a jerk.
    """
    turned = cmath.exp(1j * setup.heading)
    turn = 1j * step * setup.heading_rate
    opening = cmath.exp(-turn) * (1 + turn) - 1
    part.position = vector(turned * (anchor + opening * (anchor - centre_of_mass)))
    part.velocity = vector(
        turned * (complex(*setup.velocity) + (turn - opening) / step * anchor)
    )
