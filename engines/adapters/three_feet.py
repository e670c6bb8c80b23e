"""The capsule as rigid-body engines take it: its numbers, its slider's motion, what is read off."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.chain import FREE, ORIGIN, SLIDE, WELD, Link, Vector
from plumbob.engines.adapters.hinged_body import HingedBody, hinged_body
from plumbob.engines.adapters.stepping import Built, TakeSteps
from plumbob.engines.method import Method
from plumbob.engines.trajectory import ByName
from plumbob.models.scene import Case
from plumbob.models.tripod_capsule.model import gravity
from plumbob.models.tripod_capsule.observed import (
    Pose,
    limits,
    nearest_turn,
    observed,
)

CAPSULE = "capsule"  # the family of systems that have its model
CAPSULES = (  # what tells contact models apart, and of plans the shortest ones
    *("capsule-line/ca1", "capsule-line/heading-000", "capsule-line/heading-030"),
    *("capsule-line/heading-045", "capsule-line/frictionless", "capsule-hold/0.999"),
    *("capsule-hold/unloading", "capsule-coast", "capsule-turn/0.3", "capsule-turn/heading-*"),
    *("capsule-turn/light-slider", "capsule-turn/heavy-slider", "capsule-plan/heading-*"),
    *("capsule-plan/light-slider", "capsule-plan/heavy-slider"),
)
# A line turned about stays a line: a model of one need not run every heading.
ONE_LINE = (
    *("capsule-line/[!h]*", "capsule-line/heavy-slider", "capsule-hold", "capsule-train"),
    "capsule-coast/translation",
)
CONTACTS = Scheme("euler with contacts")  # without a theory here
POINT = 1e-14  # [kg m^2], [kg]: what engines want of bodies that have no size, or no mass
FOOT_RADIUS = 0.01  # [m] of the spheres that stand on the plane
SLIDER_RATIO = 1e8  # of the inertia that imposes the slider's motion to the capsule's mass


@dataclass(frozen=True)
class ThreeFeet:
    """A capsule's start, as rigid bodies: a free body on three feet, and a point mass on one track
    or on two at right angles."""

    setup: CapsuleSetup
    tilt_inertia: float  # about the horizontal axes [kg m^2]
    tracks: tuple[tuple[float, float], ...]  # directions of the slider's tracks, body axes

    @property
    def hold(self) -> float:
        """Inertia by which an engine may impose the slider's motion [kg]."""
        capsule = self.setup.capsule
        return SLIDER_RATIO * (capsule.body_mass + capsule.slider_mass)

    @property
    def links(self) -> tuple[Link, ...]:
        """The body, and the slider on each of its tracks, or fixed to it."""
        setup = self.setup
        capsule = self.setup.capsule
        moments = np.diag([self.tilt_inertia, self.tilt_inertia, capsule.inertia])
        links = [Link(capsule.body_mass, moments, joint=FREE)]
        place = (*setup.slider, 0.0)
        point = POINT * np.eye(3)
        tracks = self.tracks
        if not tracks:
            return *links, Link(capsule.slider_mass, point, joint=WELD, place=place)
        masses = [POINT] * (len(tracks) - 1) + [capsule.slider_mass]
        rates = self.slider_velocity(np.zeros(1))[0].tolist()
        for mass, (x, y), rate in zip(masses, tracks, rates, strict=True):
            axis = (x, y, 0.0)
            slide = Link(mass, point, joint=SLIDE, axis=axis, place=place, rate=rate)
            links.append(replace(slide, hold=self.hold))
            place = ORIGIN
        return tuple(links)

    @property
    def driven(self) -> int:
        """How many of the last joints are driven: all tracks."""
        return len(self.tracks)

    @property
    def pull(self) -> Vector:
        """Gravity in the world [m/s^2]."""
        x, y, z = gravity(self.setup).tolist()
        return x, y, z

    def slider_velocity(self, times: Array) -> Array:
        """Imposed velocity along the tracks [m/s] at times [s], shape (n,): (n, tracks)."""
        if (line := self.setup.relative_velocity) is not None:
            return np.asarray(line(times))[:, None]
        assert self.setup.plane_velocity is not None
        return self.setup.plane_velocity(times)

    def controls(self, steps: Array, step: float) -> Array:
        """Mean acceleration of the slider along its tracks [m/s^2] over the steps of `step` [s]
        with these indices, shape (n, tracks): with it the slider's velocity is right at every grid
        time, wherever the acceleration jumps."""
        # By index: the velocity that one step ends with is the one that the next begins with.
        times = np.concatenate([steps, steps + 1.0]) * step
        begun, ended = np.split(self.slider_velocity(times), 2)
        return (ended - begun) / step

    def velocities(self, steps: Array, step: float) -> Array:
        """Velocity of the slider along its tracks [m/s] at the end of each of these steps, shape
        (n, tracks)."""
        return self.slider_velocity((steps + 1.0) * step)

    def built(self, advance: TakeSteps, pose: Callable[[], Pose]) -> Built:
        """The capsule at its start in an engine which tells the `pose`, its heading to a turn."""
        latest = self.setup.heading

        def read() -> ByName:
            nonlocal latest
            now = pose()
            latest = nearest_turn(now.heading, latest)
            return observed(self.setup, replace(now, heading=latest))

        return Built(advance, read, limits(self.setup))


def scheme(case: Case, method: Method) -> Scheme:
    """The method's own where there are no contacts."""
    return CONTACTS if case.system.family == CAPSULE else method.scheme


def on_three_feet(setup: CapsuleSetup) -> ThreeFeet:
    """The bodies of a capsule."""
    tracks: tuple[tuple[float, float], ...] = ()
    if setup.relative_velocity is not None:
        tracks = ((math.cos(setup.direction), math.sin(setup.direction)),)
    elif setup.plane_velocity is not None:
        tracks = ((1.0, 0.0), (0.0, 1.0))
    # A flat body's moments about its own axes, to a factor: no exact answer depends on them.
    return ThreeFeet(setup, 0.5 * setup.capsule.inertia, tracks)


Bodies = HingedBody | ThreeFeet


def bodies(case: Case) -> Bodies:
    """Those of a capsule or a pendulum; raises Unsupported for other systems."""
    if case.system.family == CAPSULE:
        return on_three_feet(case.problem.setup)
    return hinged_body(case)
