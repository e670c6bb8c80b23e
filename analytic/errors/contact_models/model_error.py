"""Bounds on what an engine's model adds to a motion of the capsule, apart from the step: the exact
motion as every mechanism takes it, and what an error of the body does to each observable."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import NORMAL_FORCES, Capsule, steepest_load
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.analytic.systems.three_points.equations import Complex

Bounds = Mapping[str, float]
"""{observable: absolute bound}, SI units."""
ModelError = Mapping[str, Mapping[str, float]]
"""{observable: {reason: absolute bound}}, SI units."""

PLACES = 33  # in each piece of the slider's motion, for what is smooth within one
LATE = 257  # after the last one, where friction alone acts
SHORT = 1e-9  # of the motion: a piece that is shorter is rounding
STILL = 1e-9  # of the largest slip: below it a support sticks


def by_observable(parts: Mapping[str, Bounds]) -> ModelError:
    """{reason: {observable: bound}} as {observable: {reason: bound}}.

    >>> by_observable({"rounding": {"x": 1e-15, "y": 2e-15}, "depth": {"x": 1e-9}})
    {'x': {'rounding': 1e-15, 'depth': 1e-09}, 'y': {'rounding': 2e-15}}
    """
    names = dict.fromkeys(name for bounds in parts.values() for name in bounds)
    return {
        name: {why: float(bounds[name]) for why, bounds in parts.items() if name in bounds}
        for name in names
    }


@dataclass(frozen=True)
class BodyError:
    """An error of C's own position [m] and velocity [m/s], of the heading [rad] and its rate
    [rad/s], of the slider's place in the body [m] and its rate [m/s], and of the acceleration that
    its drive gives it [m/s^2]."""

    place: float = 0.0
    speed: float = 0.0
    angle: float = 0.0
    rate: float = 0.0
    slid: float = 0.0
    slider_rate: float = 0.0
    drive: float = 0.0


@dataclass(frozen=True)
class SampledMotion:
    """The exact motion, or the first of `count` equal ones, at `times` [s], shape (n,), its vectors
    as x + iy in body axes. Where it has a `formula` supports slip in fixed directions, and all
    stick or none; what is measured on a line is along `line` [rad]."""

    capsule: Capsule
    count: int
    formula: bool
    line: float
    pull: complex  # of tilted gravity [m/s^2]
    times: Array
    place: Complex  # of the slider [m]
    speed: Complex  # [m/s]
    push: Complex  # [m/s^2]
    velocity: Complex  # of C [m/s]
    rate: Array  # of the body [rad/s]
    loads: Array  # N_i [N], shape (3, n)

    @property
    def mass(self) -> float:
        """M + m [kg]."""
        return self.capsule.body_mass + self.capsule.slider_mass

    @cached_property
    def inertia(self) -> Array:
        """About the combined centre [kg m^2], shape (n,)."""
        capsule = self.capsule
        reduced = capsule.mass_ratio * capsule.body_mass
        return np.asarray(capsule.inertia + reduced * np.abs(self.place) ** 2)

    @cached_property
    def supports(self) -> Complex:
        """A_i from C [m], shape (3, 1)."""
        return (np.asarray(self.capsule.supports) @ [1.0, 1j])[:, None]

    @cached_property
    def slips(self) -> Complex:
        """Of the supports [m/s], shape (3, n); zero where one sticks."""
        slips = self.velocity + 1j * self.rate * self.supports
        size = np.abs(slips)
        return np.where(size > STILL * size.max(), slips, 0.0)

    @cached_property
    def arms(self) -> Complex:
        """Of the supports about the combined centre, CA_i - mu r [m], shape (3, n)."""
        return self.supports - self.capsule.mass_ratio * self.place

    @property
    def directions(self) -> Complex:
        """Of the slips, shape (3, n); zero where a support sticks."""
        size = np.abs(self.slips)
        return self.slips / np.where(size > 0.0, size, 1.0)

    @property
    def traction(self) -> Complex:
        """Friction over the load of each support, shape (3, n); where none slips they are alike."""
        held = self.capsule.slider_mass * self.push - self.mass * self.pull
        slides = -self.capsule.friction * self.directions
        return np.where(
            self.slips.any(axis=0),
            slides,
            bool(self.capsule.friction) * held / self.loads.sum(axis=0),
        )

    @property
    def way(self) -> float:
        """Of C, to and fro, in all of the motions [m]."""
        return self.count * float(np.trapezoid(np.abs(self.velocity), self.times))

    def bounds(self, error: BodyError, step: float, loads: Sequence[float] = ()) -> Bounds:
        """The bound of every observable in steps of `step` [s]: C turns about the combined centre,
        where it goes depends on the heading, and friction stops a velocity within a step. `loads`
        are further bounds on the N_i [N]."""
        capsule = self.capsule
        arm = self.capsule.mass_ratio * self.place
        reach = float(np.abs(arm).max())
        fastest = float(np.abs(self.velocity).max())
        place = error.place + error.angle * (reach + self.way)
        speed = error.speed + error.rate * reach + error.angle * fastest
        aside = float(np.abs((arm * np.exp(-1j * self.line)).imag).max())
        each = np.zeros(3) + error.slid * steepest_load(capsule)
        if len(loads):
            each += loads
        friction = capsule.friction * float(np.sum(loads))
        friction += self.mass * error.speed / step
        mu = capsule.mass_ratio
        return {
            **dict.fromkeys(("x", "y", "sideways"), place),
            **dict.fromkeys(("velocity_x", "velocity_y"), speed),
            "displacement": error.place + error.angle * aside,
            "velocity": error.speed + error.rate * aside,
            **dict.fromkeys(("heading", "body_angle"), error.angle),
            "heading_rate": error.rate,
            "stroke": error.slid,
            "stroke_rate": error.slider_rate,
            "friction_force": friction,
            "driving_force": mu * friction + (1.0 - mu) * capsule.slider_mass * error.drive,
            **dict(zip(NORMAL_FORCES, each.tolist(), strict=True)),
        }


def sampled(problem: CapsuleProblem, duration: float) -> SampledMotion:
    """The motion, or the first of several equal ones, until `duration` [s], finely in each piece of
    the slider's."""
    setup = problem.setup
    motion = problem.motion
    end = duration if motion.count == 1 else min(duration, motion.period)
    times = _times(motion.path, end)
    observed = problem.reference.observe(times)
    place, speed, push = (part @ [1.0, 1j] for part in motion.path.kinematics(times))
    rate = observed.get("heading_rate", 0.0 * times)
    along = np.exp(1j * setup.direction)
    if setup.in_plane:
        ground = observed["velocity_x"] + 1j * observed["velocity_y"]
        velocity = ground * np.exp(-1j * observed["heading"])
    else:
        velocity = observed["velocity"] * along
    return SampledMotion(
        setup.capsule,
        motion.count,
        motion.kind != "plane",
        float(np.angle(velocity.sum() or along)),
        setup.pull * along,
        times,
        place,
        speed,
        push,
        velocity,
        rate,
        np.array([observed[name] for name in NORMAL_FORCES]),
    )


def _times(path: SliderPath, end: float) -> Array:
    """Times until `end` [s], shape (n,): PLACES in each piece of the path, LATE after the last."""
    edges = np.unique(np.append(np.clip(path.breakpoints, 0.0, end), [0.0, end]))
    edges = edges[np.append(np.diff(edges) > SHORT * end, True)]
    counts = [PLACES] * (len(edges) - 2) + [LATE]
    parts = [
        np.linspace(a, b, n, endpoint=False)
        for (a, b), n in zip(pairwise(edges.tolist()), counts, strict=True)
    ]
    return np.append(np.concatenate(parts), end)


def support_arm(capsule: Capsule) -> float:
    """Root mean square distance of the supports from C [m]."""
    return math.sqrt(float(np.square(capsule.supports).sum()) / 3)


def radius_of_gyration(capsule: Capsule) -> float:
    """Of the body without slider about C [m]."""
    return math.sqrt(capsule.inertia / capsule.body_mass)
