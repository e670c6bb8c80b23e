"""The pendulums as rigid-body engines take them: one body on a hinge, maybe on a platform."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.parameters import finite
from plumbob.analytic.reference import Array
from plumbob.engines.adapters.chain import Link, Vector
from plumbob.engines.adapters.stepping import Built, TakeSteps
from plumbob.engines.method import Method, ModelError, Unsupported
from plumbob.engines.trajectory import ByName
from plumbob.models.cone_pendulum.model import holding_inertia, moments_about_centre
from plumbob.models.largest import rates_of_a_pendulum
from plumbob.models.scene import ONE_SMOOTH, Case
from plumbob.models.tripod_capsule.observed import Pose

PENDULUMS = (ONE_SMOOTH,)
_POINTS = ("simple_pendulum", "servo")  # families of a point on a rod, or like one
POINT = 1e-15  # [kg m^2] of a bob that is a point: engines want moments of inertia above zero


@dataclass(frozen=True)
class HingedBody:
    """A body that turns by theta about an axis along x through `pivot`, and hangs along -z at
    theta = 0; the pivot is on a platform that turns about z at `platform_rate`, or does not."""

    mass: float  # [kg]
    arm: float  # from the axis to the centre of mass [m]
    moments: Array  # about the centre of mass, in the body's axes [kg m^2], shape (3, 3)
    gravity: float  # [m/s^2]
    pivot: Vector  # [m]
    platform_rate: float | None  # [rad/s]; None: there is no platform
    theta: float  # at the start [rad]
    theta_dot: float  # [rad/s]
    damping: float  # of the hinge [N m s]
    stiffness: float  # of a spring on the hinge [N m/rad]
    forcing: tuple[float, float] | None
    """Amplitude [N m] and frequency [rad/s] of a torque on the hinge, a sine from 0."""
    limits: ByName
    """Magnitudes of observables that only a diverged run exceeds."""
    platform_inertia: float = 0.0  # by which an engine may impose the platform's rate [kg m^2]

    def controls(self, steps: Array, step: float) -> Array:
        """Of the forcing [N m] as steps of `step` [s] with these indices begin, shape (n, 1)."""
        amplitude, frequency = self.forcing or (0.0, 0.0)
        return np.asarray(amplitude * np.sin(frequency * (step * steps[:, None])))

    @property
    def driven(self) -> int:
        """How many of the last joints are driven: the hinge, if it is forced."""
        return int(self.forcing is not None)

    @property
    def pull(self) -> Vector:
        """Gravity in the world [m/s^2]."""
        return 0.0, 0.0, -self.gravity

    def built(self, advance: TakeSteps, pose: Callable[[], Pose]) -> Built:
        """The body at its start in an engine which tells the `pose`."""

        def read() -> ByName:
            now = pose()
            return {"theta": now.joint, "theta_dot": now.joint_rate}

        return Built(advance, read, self.limits)

    @property
    def links(self) -> tuple[Link, ...]:
        """The platform, if there is one, and the body on its hinge."""
        bob = Link(
            self.mass,
            self.moments,
            (0.0, 0.0, -self.arm),
            place=self.pivot,
            position=self.theta,
            rate=self.theta_dot,
            damping=self.damping,
            stiffness=self.stiffness,
        )
        if self.platform_rate is None:
            return (bob,)
        axis = (0.0, 0.0, 1.0)
        rate = self.platform_rate
        hold = self.platform_inertia
        return Link(1.0, np.eye(3), axis=axis, rate=rate, hold=hold), bob


def hinged_body(case: Case) -> HingedBody:
    """The body of a pendulum's case; raises Unsupported for other systems."""
    problem = getattr(case.problem, "started", case.problem)
    if getattr(case.problem, "saturates", False):
        raise Unsupported("a motor's limit is not carried over")
    if case.system.family in _POINTS:
        return _point(problem)
    if case.system.family == "cone_pendulum":
        return on_a_platform(problem)
    raise Unsupported(f"{case.scene.name} is no pendulum")


def model_error(case: Case, method: Method, step: float) -> ModelError:
    """Bounds on the model's error of each observable, by reason: the moment of inertia of a bob
    that should be a point. Empty for other systems: the rate of a platform is prescribed."""
    if case.system.family not in _POINTS:
        return {}
    return bob_errors(getattr(case.problem, "started", case.problem), case.scene.duration)


def model_error_on_platform(case: Case, method: Method, step: float) -> ModelError:
    """The same where a platform keeps its rate by an inertia that is finite."""
    if case.system.family != "cone_pendulum":
        return model_error(case, method, step)
    return platform_errors(case.problem.started, case.scene.duration)


def platform_errors(problem: Any, duration: float) -> ModelError:
    """Bounds over `duration` [s] from the inertia of a platform that should keep its rate."""
    from plumbob.analytic.errors.contact_models.added_inertia import platform_error

    errors = platform_error(problem, duration, on_a_platform(problem).platform_inertia)
    return {
        name: {"inertia of the platform": bound}
        for name, bound in zip(("theta", "theta_dot"), errors, strict=True)
    }


def bob_errors(problem: Any, duration: float) -> ModelError:
    """Bounds over `duration` [s] from the moment of inertia of a bob that should be a point."""
    from plumbob.analytic.errors.contact_models.added_inertia import bob_error

    bounds = bob_error(problem, duration, POINT / (problem.mass * problem.length**2))
    return {name: {"moment of inertia of the bob": bound} for name, bound in bounds.items()}


def _point(problem: Any) -> HingedBody:
    moment = problem.mass * problem.length**2
    push = (moment * problem.forcing_amplitude, problem.forcing_frequency)
    return HingedBody(
        mass=problem.mass,
        arm=problem.length,
        moments=POINT * np.eye(3),
        gravity=0.0 if problem.linear else problem.gravity,
        pivot=(0.0, 0.0, 0.0),
        platform_rate=None,
        theta=problem.theta,
        theta_dot=problem.theta_dot,
        damping=problem.damping_rate * moment,
        stiffness=problem.mass * problem.gravity * problem.length if problem.linear else 0.0,
        forcing=push if problem.forcing_amplitude else None,
        limits=rates_of_a_pendulum(problem),
    )


def on_a_platform(problem: Any) -> HingedBody:
    """The body of a ConePendulum."""
    body = problem.body
    return HingedBody(
        mass=body.mass,
        arm=body.com_distance,
        moments=moments_about_centre(body),
        gravity=problem.gravity,
        pivot=(problem.pivot_x, problem.pivot_y, problem.pivot_z),
        platform_rate=problem.platform_rate,
        theta=finite("theta", problem.theta),
        theta_dot=finite("theta_dot", problem.theta_dot),
        damping=0.0,
        stiffness=0.0,
        forcing=None,
        limits=rates_of_a_pendulum(problem),
        platform_inertia=holding_inertia(problem),
    )
