"""The turn manoeuvre: the slider moves round a circle and the body turns the other way, to order
epsilon^2 (Chernousko 2020, eqs. 24-32; the second order is derived in analytic/README.md)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.parameters import ParameterError, finite, positive
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import ROUNDOFF, Capsule, Path, validity
from plumbob.analytic.systems.manoeuvres.turn_correction import (
    TurnCorrection,
    TurnPose,
    circle_inertia,
    inertia_ratio,
    progress,
    turn_correction,
)
from plumbob.analytic.systems.slider_path import SliderPath, arc_stroke


@dataclass(frozen=True)
class TurnManoeuvre:
    """Slider from rest to rest on a circle of `radius` a [m] about C, with angular acceleration Z
    [rad/s^2] (of either sign) for tau = `half_time` [s], then -Z for tau (eq. 29); it starts at
    `start` [rad] from the body's x axis, the body at rest with heading 0 and C at the origin.

    Raises ParameterError, also when a normal force is not positive along the arc.

    >>> corners = ((0.2, 0.0), (-0.1, 0.15), (-0.1, -0.15))
    >>> capsule = Capsule(1.0, 0.3, 0.02, corners, friction=0.3, gravity=9.81)
    >>> turn = turn_of(capsule, radius=0.12, epsilon=0.1, body_angle=-1.0)
    >>> print(f"{turn.body_angle:.6f} rad; to second order {turn.corrected_pose.heading:.6f} rad")
    -1.000000 rad; to second order -0.988798 rad
    """

    capsule: Capsule
    radius: float
    angular_acceleration: float
    half_time: float
    start: float = 0.0

    def __post_init__(self) -> None:
        positive("radius", self.radius), positive("half_time", self.half_time)
        finite("start", self.start)
        if finite("angular_acceleration", self.angular_acceleration) == 0.0:
            raise ParameterError("angular_acceleration", 0.0, "other than 0")
        for breach in validity(self.capsule, self.track):
            raise breach

    @property
    def inertia(self) -> float:
        """J + mu M a^2 [kg m^2], of body and slider about their combined centre (eq. 23)."""
        return circle_inertia(self.capsule, self.radius)

    @property
    def inertia_ratio(self) -> float:
        """mu_1 = mu M a^2/(J + mu M a^2) (eq. 25)."""
        return inertia_ratio(self.capsule, self.radius)

    @property
    def friction_bound(self) -> float:
        """R_0 [rad/s^2], at least the angular acceleration that friction can give (eq. 28)."""
        return self.capsule.friction * self._friction_pace

    @property
    def least_friction(self) -> float:
        """The friction that over the manoeuvre, 2 tau, could change the body's largest rate,
        mu_1 |Z| tau, by the rounding of a double: below it the time of rest is undetermined."""
        rate = self.inertia_ratio * abs(self.angular_acceleration) * self.half_time
        return ROUNDOFF * rate / (2.0 * self.half_time * self._friction_pace)

    @property
    def _friction_pace(self) -> float:
        """R_0 per friction coefficient [rad/s^2]."""
        arm = max(math.hypot(*point) for point in self.capsule.supports)
        reach = arm + self.capsule.mass_ratio * self.radius
        return reach * self.capsule.weight / self.inertia

    @property
    def characteristic_time(self) -> float:
        """T = R_0^(-1/2) [s] (eq. 28); infinite without friction."""
        bound = self.friction_bound
        return 1.0 / math.sqrt(bound) if bound > 0.0 else math.inf

    @property
    def epsilon(self) -> float:
        """tau/T, the small parameter of the formulas (eq. 30)."""
        return self.half_time / self.characteristic_time

    @property
    def drive_ratio(self) -> float:
        """mu_1 |Z|/R_0 over epsilon^-2, of order 1 where the formulas apply (eq. 30): it is the
        angle |delta psi| [rad] of eq. 32."""
        return abs(self.body_angle)

    @property
    def slider_angle(self) -> float:
        """delta phi = Z tau^2 [rad], the slider's whole angle (eq. 32)."""
        return self.angular_acceleration * self.half_time**2

    @property
    def body_angle(self) -> float:
        """delta psi = -mu_1 Z tau^2 [rad], the body's turn to leading order (eq. 32)."""
        return -self.inertia_ratio * self.slider_angle

    def slider_angles(self, times: Array) -> Array:
        """phi [rad] from its start at `times` [s], shape (n,) (eqs. 26, 27, 29)."""
        phase = np.clip(np.asarray(times) / self.half_time, 0.0, 2.0)
        return self.slider_angle * progress(phase)

    def body_angles(self, times: Array) -> Array:
        """psi = -mu_1 phi [rad] at `times` [s], shape (n,), to leading order (eq. 31)."""
        return -self.inertia_ratio * self.slider_angles(times)

    @property
    def path(self) -> SliderPath:
        """The slider's motion, for `plumbob.analytic.systems.three_points.friction`."""
        return arc_stroke(self.radius, self.start, self.angular_acceleration, self.half_time)

    @property
    def track(self) -> Path:
        """The slider's arc."""
        return self.path.track()

    @cached_property
    def leading_pose(self) -> TurnPose:
        """Pose at 2 tau, and at rest, to leading order: eq. 32, and C moving round the
        combined centre, which friction displaces only at second order."""
        first = self._arm(0.0)
        moved = first - np.exp(1j * self.body_angle) * self._arm(self.slider_angle)
        return TurnPose(float(moved.real), float(moved.imag), self.body_angle)

    @cached_property
    def correction(self) -> TurnCorrection:
        """Second-order coefficients (analytic/README.md, eqs. 3-6)."""
        return turn_correction(self.capsule, self.radius, self.slider_angle, self.start)

    @property
    def corrected_pose(self) -> TurnPose:
        """Pose at 2 tau with the second order added."""
        return _added(self.leading_pose, self.correction.at_stop, self.half_time**2)

    @property
    def corrected_pose_at_rest(self) -> TurnPose:
        """Pose at rest with the second order added."""
        return _added(self.leading_pose, self.correction.at_rest, self.half_time**2)

    @property
    def rates_at_stop(self) -> TurnPose:
        """Velocity and angular velocity left at 2 tau, of which eq. 32 has none, to leading order:
        in proportion to tau."""
        return _added(TurnPose(0.0, 0.0, 0.0), self.correction.left_at_stop, self.half_time)

    @property
    def rest_time(self) -> float:
        """Time at which the body comes to rest [s], to leading order."""
        return self.half_time * (2.0 + self.correction.residual_time)

    def _arm(self, angle: float) -> complex:
        """mu r [m] with the slider at `angle` [rad] from its start."""
        place = self.radius * np.exp(1j * (self.start + angle))
        return complex(self.capsule.mass_ratio * place)


def _added(pose: TurnPose, coefficients: TurnPose, scale: float) -> TurnPose:
    return TurnPose(
        pose.x + scale * coefficients.x,
        pose.y + scale * coefficients.y,
        pose.heading + scale * coefficients.heading,
    )


def turn_of(
    capsule: Capsule, radius: float, epsilon: float, body_angle: float = -1.0, start: float = 0.0
) -> TurnManoeuvre:
    """The manoeuvre with tau = epsilon T that turns the body by `body_angle` [rad] to leading order
    (eqs. 28, 30, 32). Raises ParameterError."""
    positive("epsilon", epsilon)
    if finite("body_angle", body_angle) == 0.0:
        raise ParameterError("body_angle", body_angle, "other than 0")
    if capsule.friction == 0.0:
        raise ParameterError("friction", 0.0, "greater than 0, for epsilon to be defined")
    scale = TurnManoeuvre(capsule, radius, 1.0, 1e-9, start)
    half_time = epsilon * scale.characteristic_time
    drive = -body_angle / (scale.inertia_ratio * half_time**2)
    return TurnManoeuvre(capsule, radius, drive, half_time, start)
