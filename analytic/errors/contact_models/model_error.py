"""Model-error bounds on a motion of the capsule: shared records and functions.

A model error is an error of an engine's model that does not depend on the step. This module samples
the exact motion, and turns an error of the body into bounds on every observable.
"""

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
from plumbob.analytic.systems.three_points.equations import ComplexForces

Bounds = Mapping[str, float]
"""{observable: absolute bound}, SI units."""
ObservableErrors = Mapping[str, Mapping[str, float]]
"""{observable: {reason: absolute bound}}, SI units."""

SAMPLES_PER_PIECE = 33  # samples in each smooth piece of the slider's motion
SAMPLES_AFTER_PIECES = 257  # samples after the last piece, where only friction acts
SHORTEST_PIECE = 1e-9  # fraction of the motion: a shorter piece is an artefact of rounding
STICKING_SLIP = 1e-9  # fraction of the largest slip below which a support sticks


def by_observable(parts: Mapping[str, Bounds]) -> ObservableErrors:
    """Returns {reason: {observable: bound}} regrouped as {observable: {reason: bound}}.

    >>> by_observable({"rounding": {"x": 1e-15, "y": 2e-15}, "depth": {"x": 1e-9}})
    {'x': {'rounding': 1e-15, 'depth': 1e-09}, 'y': {'rounding': 2e-15}}
    """
    by_name: dict[str, dict[str, float]] = {}
    for reason, bounds in parts.items():
        for name, bound in bounds.items():
            by_name.setdefault(name, {})[reason] = float(bound)
    return by_name


@dataclass(frozen=True)
class BodyError:
    """Bounds on the errors of a body and its slider."""

    place: float = 0.0  # [m] position of the body's centre C
    speed: float = 0.0  # [m/s] velocity of C
    angle: float = 0.0  # [rad] heading
    rate: float = 0.0  # [rad/s] rate of the heading
    slider_place: float = 0.0  # [m] position of the slider in the body
    slider_rate: float = 0.0  # [m/s] rate of the slider in the body
    drive: float = 0.0  # [m/s^2] acceleration of the slider by its drive


@dataclass(frozen=True)
class SampledMotion:
    """The exact motion of a capsule, sampled; vectors are x + iy in body axes.

    If a manoeuvre is repeated, the samples cover its first run.
    """

    capsule: Capsule
    count: int  # equal manoeuvres in the motion
    formula: bool  # closed form: supports slip in fixed directions, and all stick or none
    line: float  # [rad] direction in which observables on a line are measured
    pull: complex  # [m/s^2] horizontal part of tilted gravity
    times: Array  # [s] shape (n,)
    place: ComplexForces  # [m] position of the slider, shape (n,)
    speed: ComplexForces  # [m/s] velocity of the slider in the body
    push: ComplexForces  # [m/s^2] acceleration of the slider in the body
    velocity: ComplexForces  # [m/s] velocity of C
    rate: Array  # [rad/s] angular velocity of the body
    loads: Array  # N_i [N], shape (3, n)

    @property
    def mass(self) -> float:
        """Mass of body and slider, M + m [kg]."""
        return self.capsule.body_mass + self.capsule.slider_mass

    @cached_property
    def inertia(self) -> Array:
        """Moment of inertia about the combined centre of mass [kg m^2], shape (n,)."""
        capsule = self.capsule
        reduced = capsule.mass_ratio * capsule.body_mass
        return np.asarray(capsule.inertia + reduced * np.abs(self.place) ** 2)

    @cached_property
    def supports(self) -> ComplexForces:
        """Positions A_i of the supports from C [m], shape (3, 1)."""
        return (np.asarray(self.capsule.supports) @ [1.0, 1j])[:, None]

    @cached_property
    def slips(self) -> ComplexForces:
        """Slip velocities of the supports [m/s], shape (3, n); zero if a support sticks."""
        slips = self.velocity + 1j * self.rate * self.supports
        size = np.abs(slips)
        return np.where(size > STICKING_SLIP * size.max(), slips, 0.0)

    @cached_property
    def arms(self) -> ComplexForces:
        """Positions of the supports from the combined centre, CA_i - mu r [m], shape (3, n)."""
        return self.supports - self.capsule.mass_ratio * self.place

    @property
    def directions(self) -> ComplexForces:
        """Unit vectors along the slips, shape (3, n); zero if a support sticks."""
        size = np.abs(self.slips)
        return self.slips / np.where(size > 0.0, size, 1.0)

    @property
    def traction(self) -> ComplexForces:
        """Friction over the load of each support, shape (3, n); equal for all if none slips."""
        sliding = -self.capsule.friction * self.directions
        holding_force = self.capsule.slider_mass * self.push - self.mass * self.pull
        sticking = bool(self.capsule.friction) * holding_force / self.loads.sum(axis=0)
        return np.where(self.slips.any(axis=0), sliding, sticking)

    @property
    def path_length(self) -> float:
        """Path length of C in all manoeuvres together [m]."""
        return self.count * float(np.trapezoid(np.abs(self.velocity), self.times))

    def bounds(self, error: BodyError, step: float, loads: Sequence[float] = ()) -> Bounds:
        """Returns the bound on every observable from an `error` of the body, for a `step` [s].

        `loads` are further bounds on the errors of the N_i [N]; empty for none. The reference point
        of the body is C, but the body turns about the combined centre of mass: an error of the
        heading moves C as well, and changes the direction of C's path. An error of the velocity,
        which friction stops within a step, is an error of the friction force.
        """
        capsule = self.capsule
        mu = capsule.mass_ratio
        arm = mu * self.place  # combined centre of mass from C
        longest_arm = float(np.abs(arm).max())
        largest_offset = float(np.abs((arm * np.exp(-1j * self.line)).imag).max())
        fastest = float(np.abs(self.velocity).max())
        place = error.place + error.angle * (longest_arm + self.path_length)
        speed = error.speed + error.rate * longest_arm + error.angle * fastest
        normal_forces = np.zeros(3) + error.slider_place * steepest_load(capsule)
        if len(loads):
            normal_forces += loads
        friction = capsule.friction * float(np.sum(loads))
        friction += self.mass * error.speed / step
        return {
            **dict.fromkeys(("x", "y", "sideways"), place),
            **dict.fromkeys(("velocity_x", "velocity_y"), speed),
            "displacement": error.place + error.angle * largest_offset,
            "velocity": error.speed + error.rate * largest_offset,
            **dict.fromkeys(("heading", "body_angle"), error.angle),
            "heading_rate": error.rate,
            "stroke": error.slider_place,
            "stroke_rate": error.slider_rate,
            "friction_force": friction,
            "driving_force": mu * friction + (1.0 - mu) * capsule.slider_mass * error.drive,
            **dict(zip(NORMAL_FORCES, normal_forces.tolist(), strict=True)),
        }


def sample_motion(problem: CapsuleProblem, duration: float) -> SampledMotion:
    """Returns a problem's exact motion up to `duration` [s], sampled finely in each piece of the
    slider's motion; the first manoeuvre only if a manoeuvre is repeated."""
    setup = problem.setup
    motion = problem.motion
    end = duration if motion.count == 1 else min(duration, motion.period)
    times = _sample_times(motion.path, end)
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
        capsule=setup.capsule,
        count=motion.count,
        formula=motion.kind != "plane",
        line=float(np.angle(velocity.sum() or along)),
        pull=setup.pull * along,
        times=times,
        place=place,
        speed=speed,
        push=push,
        velocity=velocity,
        rate=rate,
        loads=np.array([observed[name] for name in NORMAL_FORCES]),
    )


def _sample_times(path: SliderPath, end: float) -> Array:
    """Returns times up to `end` [s], shape (n,): SAMPLES_PER_PIECE in each piece of the path, then
    SAMPLES_AFTER_PIECES."""
    edges = np.unique(np.append(np.clip(path.breakpoints, 0.0, end), [0.0, end]))
    edges = edges[np.append(np.diff(edges) > SHORTEST_PIECE * end, True)]
    counts = [SAMPLES_PER_PIECE] * (len(edges) - 2) + [SAMPLES_AFTER_PIECES]
    pieces = []
    for (begin, until), count in zip(pairwise(edges.tolist()), counts, strict=True):
        pieces.append(np.linspace(begin, until, count, endpoint=False))
    return np.append(np.concatenate(pieces), end)


def support_arm(capsule: Capsule) -> float:
    """Returns the root mean square distance of the supports from C [m]."""
    return math.sqrt(float(np.square(capsule.supports).sum()) / 3)


def radius_of_gyration(capsule: Capsule) -> float:
    """Returns the radius of gyration of the body without slider about C [m]."""
    return math.sqrt(capsule.inertia / capsule.body_mass)
