"""Errors from inertia that an engine adds to a model.

A platform of finite armature A. Free but for its armature, it does not quite keep its rate w. With
the body's inertia about the vertical axis J(theta) and the coupling K(theta) = M X S cos theta of
the two rotations,

    L = (A + J) w^2 / 2 + K w theta' + I_x theta'^2 / 2 + c cos theta,
    J = J0 + 2 M Y S sin theta + (I_y - I_z) sin^2 theta + I_yz sin 2 theta,

where A -> infinity gives Sudakov 2015, eq. 7. The momentum about the vertical, which is
(A + J) w + K theta', is constant, so to first order in 1/A the rate is w0 + u/A with

    u = -w0 (J - J(0)) - (K theta' - K(0) theta'(0)),

and the error of theta is d/A, where d obeys the equation of motion linearised along the swing,

    I_x d'' = (J'' w0^2 / 2 - c cos theta) d + J' w0 u - K u',        d(0) = d'(0) = 0.

A slider's joint of armature A that a motor of gear A drives follows its control but for m/A of what
else accelerates the slider. A pendulum's bob of moment of inertia I, meant to be a point, is like
a mass m l^2 that is larger by I.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from plumbob.analytic.numerics.rotor.variational import TangentFlow, tangent_flow
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import NORMAL_FORCES, ROUNDOFF, load_slopes
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.manoeuvres.line_reference import condition_number

DRIVE_ROUNDINGS = 16  # of what drives the slider's joint
TIME_ROUNDINGS = 4  # of the times at which its velocity is evaluated, at most the duration
POINTS = 200  # samples of a pendulum's motion


@dataclass(frozen=True)
class PlatformLoad:
    """J(theta) - J0, K(theta) and their slopes [kg m^2]."""

    lever: float  # 2 M Y S
    skew: float  # I_y - I_z
    product: float  # I_yz
    reach: float  # M X S

    @classmethod
    def of(cls, pendulum: Any) -> PlatformLoad:
        """That of a pendulum on a platform."""
        body = pendulum.body
        arm = body.mass * body.com_distance
        skew = body.inertia_y - body.inertia_z
        return cls(2 * arm * pendulum.pivot_y, skew, body.inertia_yz, arm * pendulum.pivot_x)

    def inertia(self, angle: Any) -> Any:
        """J - J0."""
        level = self.lever * np.sin(angle) + self.skew * np.sin(angle) ** 2
        return level + self.product * np.sin(2 * angle)

    def inertia_slope(self, angle: Any) -> Any:
        """J'."""
        level = self.lever * np.cos(angle) + self.skew * np.sin(2 * angle)
        return level + 2 * self.product * np.cos(2 * angle)

    def inertia_bend(self, angle: Any) -> Any:
        """J''."""
        level = -self.lever * np.sin(angle) + 2 * self.skew * np.cos(2 * angle)
        return level - 4 * self.product * np.sin(2 * angle)

    def coupling(self, angle: Any) -> Any:
        """K."""
        return self.reach * np.cos(angle)

    def coupling_slope(self, angle: Any) -> Any:
        """K'."""
        return -self.reach * np.sin(angle)


@lru_cache(maxsize=64)  # the same for every method and step of a scene
def platform_error(problem: Any, duration: float, armature: float) -> tuple[float, float]:
    """Largest error of theta [rad] and theta_dot [rad/s] within `duration` [s] that the platform's
    `armature` [kg m^2] brings, to first order in its inverse (module docstring)."""
    load, rate = PlatformLoad.of(problem), problem.platform_rate
    start = problem.theta + problem.tilt  # the rotor's angle
    flow = tangent_flow(problem.motion.rotor, start, problem.theta_dot, duration)
    states = flow.states
    theta, theta_dot = states[0] - problem.tilt, states[1]
    inertia_slope, coupling = load.inertia_slope(theta), load.coupling(theta)
    u = rate * (load.inertia(problem.theta) - load.inertia(theta))
    u += load.coupling(problem.theta) * problem.theta_dot - coupling * theta_dot
    u_rate = -rate * inertia_slope * theta_dot
    theta_dot_dot = flow.rotor.acceleration(0.0, *states)
    u_rate -= load.coupling_slope(theta) * theta_dot**2 + coupling * theta_dot_dot
    push = (inertia_slope * rate * u - coupling * u_rate) / problem.body.inertia_x
    worst = _largest_response(flow, push) / armature
    return float(worst[0]), float(worst[1])


def _largest_response(flow: TangentFlow, push: Array) -> Array:
    """Of theta and theta_dot to an acceleration `push` [rad/s^2] at the nodes."""
    forcing = np.stack([np.zeros_like(push), push], axis=-1)[..., None]
    reached = flow.respond(np.zeros((2, 1)), forcing).at_nodes()[..., 0]
    return np.asarray(np.abs(reached).max(axis=(0, 1)))


@lru_cache(maxsize=64)  # the same for every method and step of a scene
def bob_error(problem: Any, duration: float, moment_ratio: float) -> Mapping[str, float]:
    """Bounds on the observables of a SimplePendulum over `duration` [s] whose bob's moment of
    inertia is `moment_ratio` of m l^2: at most the effect of as many units in the last place of
    every parameter as it has."""
    doubts = problem.motion.uncertainty(np.linspace(0.0, duration, POINTS))
    return {
        name: moment_ratio / (2 * ROUNDOFF) * float(doubt.max()) for name, doubt in doubts.items()
    }


def slider_on_a_line(
    problem: CapsuleProblem,
    times: Array,
    armature: float,
    step: float,
    line: LineManoeuvre | None,
    count: int,
) -> Mapping[str, float]:
    """Bounds where the slider's way in the body lacks m/A of its way in space, at `times` [s],
    shape (n,), for an `armature` [kg] and steps of `step` [s]; of `count` manoeuvres `line` where
    the motion is these."""
    setup, duration = problem.setup, float(times[-1])
    part, mu = setup.capsule.slider_mass / armature, setup.capsule.mass_ratio
    observed = problem.reference.observe(times)
    way = float((np.abs(observed["stroke"]) + np.abs(observed["displacement"])).max())
    rate = float((np.abs(observed["stroke_rate"]) + np.abs(observed["velocity"])).max())
    moved, left = 0.0, 0.0
    if line is not None:
        moved = condition_number(line) * abs(line.displacement) * count
        # The velocity that is left when the times are rounded.
        left = TIME_ROUNDINGS * ROUNDOFF * duration * line.w1
    slid = part * way + left * duration
    slope = float(np.abs(load_slopes(setup.capsule, setup.direction)).max())
    driven = (part + DRIVE_ROUNDINGS * ROUNDOFF) * rate
    # Friction that stops the body takes its velocity in a step; where there is none it is rounding.
    stopped = driven if setup.capsule.friction else DRIVE_ROUNDINGS * ROUNDOFF * rate
    # The lag of the slider grows with its acceleration in space, F/m; rounding recurs every step.
    lagging = part * float(np.abs(observed["driving_force"]).max())
    lagging += 2.0 * DRIVE_ROUNDINGS * ROUNDOFF * rate * setup.capsule.slider_mass / step
    friction = setup.capsule.slider_mass * stopped / step
    return {
        "stroke": slid,
        "stroke_rate": driven,
        "driving_force": mu * friction + (1.0 - mu) * lagging,
        "displacement": part * moved,
        "velocity": mu * driven,  # while it slides: the reaction is m/(M + m) of the acceleration
        "friction_force": friction,
        **dict.fromkeys(NORMAL_FORCES, slid * slope),
    }


def slider_in_the_plane(
    slider_mass: float, armature: float, times: Array, speeds: Array
) -> tuple[float, float]:
    """Bounds on a slider's way [m] and velocity [m/s] in the body, and on the body's, where its
    speeds in space are at most `speeds` [m/s], shape (n,), at `times` [s], shape (n,)."""
    part = slider_mass / armature + DRIVE_ROUNDINGS * ROUNDOFF
    return part * float(np.trapezoid(speeds, times)), part * float(speeds.max())
