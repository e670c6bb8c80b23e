"""The turn manoeuvre: the slider moves round a circle and the body turns the other way (Chernousko
2020, eqs. 24-32).

The source stops at eq. 32, the leading order in epsilon. The second order is the effect of friction
along the leading-order motion. It is derived in analytic/README.md, with the equation numbers used
here.

    mu       m/(M + m), `Capsule.mass_ratio`
    mu_1     mu M a^2/(J + mu M a^2), `inertia_ratio`
    Z, tau   angular acceleration of the slider, and the time for which it acts either way
    phi, psi angle of the slider, and heading of the body
    R_0, T   `friction_bound`, and the `characteristic_time` R_0^(-1/2)
    epsilon  tau/T
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError, check_fields, finite, positive
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import ROUNDOFF, Capsule, check_loads, normal_forces
from plumbob.analytic.systems.slider_path import SliderPath, arc_stroke, fixed
from plumbob.analytic.systems.three_points.equations import ComplexForces
from plumbob.analytic.systems.three_points.friction import InitialVelocities, three_point_motion

QUADRATURE_TOLERANCE = 1e-13  # relative tolerance of the quadrature
MAX_INTERVALS = 1000  # largest number of the quadrature's intervals
# The coasting body turns by about the square of this [rad]; the limit neglects that turn.
NEGLECTED_TURN_ROOT = 1e-6


@dataclass(frozen=True)
class TurnCorrection:
    """Second-order coefficients of a turn manoeuvre. A pose is (x and y of C [m], heading [rad]),
    shape (3,).

    `at_stop` and `at_rest` are the coefficients of tau^2 in the pose when the slider stops (at 2
    tau) and when the body rests. `rate_coefficients` are those of tau in the pose's rates when the
    slider stops. `residual_time` is the coefficient of tau in the time from the slider's stop to
    rest.
    """

    at_stop: Array
    at_rest: Array
    rate_coefficients: Array
    residual_time: float


def angle_fraction(phases: Array) -> Array:
    """Returns the fraction of the slider's angle covered at times `phases` tau, shape (n,), up to 2
    tau (Chernousko 2020, eqs. 26, 29)."""
    return 0.5 * np.square(phases) - np.square(np.maximum(phases - 1.0, 0.0))


@dataclass(frozen=True)
class TurnManoeuvre:
    """The slider moves from rest to rest on a circle of `radius` a [m] about C. Its angular
    acceleration is Z [rad/s^2], of either sign, for tau = `half_time` [s], then -Z for tau (eq.
    29). It starts at `start` [rad] from the body's x axis, with the body at rest, heading 0 and C
    at the origin.

    Raises ParameterError, also if a normal force is not positive along the arc.

    >>> corners = ((0.2, 0.0), (-0.1, 0.15), (-0.1, -0.15))
    >>> capsule = Capsule(1.0, 0.3, 0.02, corners, friction=0.3, gravity=9.81)
    >>> turn = turn_of(capsule, radius=0.12, epsilon=0.1, body_angle=-1.0)
    >>> print(f"{turn.body_angle:.6f} rad; to second order {turn.corrected_pose[2]:.6f} rad")
    -1.000000 rad; to second order -0.988798 rad
    """

    capsule: Capsule
    radius: float
    angular_acceleration: float
    half_time: float
    start: float = 0.0

    def __post_init__(self) -> None:
        check_fields(self, ("radius", "half_time"), others=("capsule",))
        if self.angular_acceleration == 0.0:
            raise ParameterError("angular_acceleration", 0.0, "other than 0")
        check_loads(self.capsule, self.path.track())

    @property
    def inertia(self) -> float:
        """The moment of inertia of body and slider about their combined centre, J + mu M a^2 [kg
        m^2] (eqs. 23, 25)."""
        return self.capsule.inertia + self._slider_inertia

    @property
    def inertia_ratio(self) -> float:
        """The slider's part of `inertia`, mu_1 = mu M a^2/(J + mu M a^2) (eq. 25)."""
        return self._slider_inertia / self.inertia

    @property
    def _slider_inertia(self) -> float:
        """The slider's term in `inertia`, mu M a^2 [kg m^2]."""
        return self.capsule.mass_ratio * self.capsule.body_mass * self.radius**2

    @property
    def friction_bound(self) -> float:
        """A bound on the angular acceleration that friction can cause, R_0 [rad/s^2] (eq. 28)."""
        return self.capsule.friction * self._unit_friction_bound

    @property
    def least_friction(self) -> float:
        """The smallest friction coefficient that determines the time of rest. A smaller friction
        changes the body's largest rate, mu_1 |Z| tau, over the manoeuvre, 2 tau, by less than the
        rounding of a double."""
        rate = self.inertia_ratio * abs(self.angular_acceleration) * self.half_time
        return ROUNDOFF * rate / (2.0 * self.half_time * self._unit_friction_bound)

    @property
    def _unit_friction_bound(self) -> float:
        """The friction bound R_0 divided by the friction coefficient [rad/s^2]."""
        arm = max(math.hypot(*point) for point in self.capsule.supports)
        reach = arm + self.capsule.mass_ratio * self.radius
        return reach * self.capsule.weight / self.inertia

    @property
    def characteristic_time(self) -> float:
        """The time scale of friction, T = R_0^(-1/2) [s] (eq. 28); infinite without friction."""
        bound = self.friction_bound
        return 1.0 / math.sqrt(bound) if bound > 0.0 else math.inf

    @property
    def epsilon(self) -> float:
        """tau/T, the small parameter of the formulas (eq. 30)."""
        return self.half_time / self.characteristic_time

    @property
    def drive_ratio(self) -> float:
        """mu_1 |Z| epsilon^2/R_0, which must be of order 1 for the formulas to apply (eq. 30). It
        equals the angle |delta psi| [rad] of eq. 32."""
        return abs(self.body_angle)

    @property
    def slider_angle(self) -> float:
        """delta phi = Z tau^2 [rad], the slider's total angle (eq. 32)."""
        return self.angular_acceleration * self.half_time**2

    @property
    def body_angle(self) -> float:
        """delta psi = -mu_1 Z tau^2 [rad], the body's turn to leading order (eq. 32)."""
        return -self.inertia_ratio * self.slider_angle

    def slider_angles(self, times: Array) -> Array:
        """Returns the slider's angle phi from its start [rad] at `times` [s], shape (n,) (eqs. 26,
        27, 29)."""
        phase = np.clip(np.asarray(times) / self.half_time, 0.0, 2.0)
        return self.slider_angle * angle_fraction(phase)

    def body_angles(self, times: Array) -> Array:
        """Returns the heading psi = -mu_1 phi [rad] at `times` [s], shape (n,), to leading order
        (eq. 31)."""
        return -self.inertia_ratio * self.slider_angles(times)

    @property
    def path(self) -> SliderPath:
        """The slider's path, for `plumbob.analytic.systems.three_points.friction`."""
        return arc_stroke(self.radius, self.start, self.angular_acceleration, self.half_time)

    @cached_property
    def leading_pose(self) -> Array:
        """Pose (x, y, heading) at 2 tau, shape (3,), to leading order: heading by eq. 32, C by its
        motion round the combined centre, which friction displaces only at second order. The body
        rests in the same pose."""
        first_arm = self._arm(0.0)
        last_arm = self._arm(self.slider_angle)
        displacement = first_arm - np.exp(1j * self.body_angle) * last_arm
        return np.array([displacement.real, displacement.imag, self.body_angle])

    @cached_property
    def correction(self) -> TurnCorrection:
        """Second-order coefficients (analytic/README.md, eqs. 3-6)."""
        return _correction(self)

    @property
    def corrected_pose(self) -> Array:
        """Pose at 2 tau to second order, shape (3,)."""
        return self.leading_pose + self.half_time**2 * self.correction.at_stop

    @property
    def corrected_pose_at_rest(self) -> Array:
        """Pose at rest to second order, shape (3,)."""
        return self.leading_pose + self.half_time**2 * self.correction.at_rest

    @property
    def rates_at_stop(self) -> Array:
        """Velocity of C [m/s] and angular velocity [rad/s] at 2 tau to leading order, shape (3,):
        they are in proportion to tau. Eq. 32 neglects them."""
        return self.half_time * self.correction.rate_coefficients

    @property
    def rest_time(self) -> float:
        """Time at which the body comes to rest [s], to leading order."""
        return self.half_time * (2.0 + self.correction.residual_time)

    def _arm(self, angle: float) -> complex:
        """Returns mu r [m] with the slider at `angle` [rad] from its start."""
        place = self.radius * np.exp(1j * (self.start + angle))
        return complex(self.capsule.mass_ratio * place)


def turn_of(
    capsule: Capsule,
    radius: float,
    epsilon: float,
    body_angle: float = -1.0,
    start: float = 0.0,
) -> TurnManoeuvre:
    """Returns the manoeuvre with tau = epsilon T that turns the body by `body_angle` [rad] to
    leading order (eqs. 28, 30, 32). Raises ParameterError."""
    positive("epsilon", epsilon)
    if finite("body_angle", body_angle) == 0.0:
        raise ParameterError("body_angle", body_angle, "other than 0")
    if capsule.friction == 0.0:
        raise ParameterError("friction", 0.0, "greater than 0, for epsilon to be defined")
    # The characteristic time and the inertia ratio are the same for all turns of this radius.
    trial = TurnManoeuvre(capsule, radius, 1.0, 1e-9, start)
    half_time = epsilon * trial.characteristic_time
    acceleration = -body_angle / (trial.inertia_ratio * half_time**2)
    return TurnManoeuvre(capsule, radius, acceleration, half_time, start)


def leading_friction(turn: TurnManoeuvre, slider_angles: Array) -> tuple[ComplexForces, Array]:
    """Returns the friction along the leading-order motion (eq. 2): the resultant in body axes [N],
    complex, and the moment about the combined centre [N m], both of shape (n,).

    `slider_angles` phi [rad], shape (n,), are from the body's x axis. Support i moves along -k x
    s_i with s_i = mu_1 CA_i + mu (1 - mu_1) r.
    """
    capsule = turn.capsule
    mu_1 = turn.inertia_ratio
    mu = capsule.mass_ratio
    r = turn.radius * np.exp(1j * slider_angles)
    supports = np.array([complex(*point) for point in capsule.supports])
    slip = mu_1 * supports + mu * (1.0 - mu_1) * r[:, None]
    size = np.abs(slip)
    unit = np.sign(turn.slider_angle) * slip / np.where(size > 0.0, size, 1.0)
    limits = capsule.friction * normal_forces(capsule, np.column_stack([r.real, r.imag]))
    moments = ((supports - mu * r[:, None]).conjugate() * unit).real
    force = np.asarray((limits * 1j * unit).sum(axis=1))
    return force, np.asarray((limits * moments).sum(axis=1))


def _correction(turn: TurnManoeuvre) -> TurnCorrection:
    """Returns the coefficients of tau^2 in the pose at 2 tau and at rest (eqs. 3-6), and those of
    tau in the velocities at 2 tau."""
    from scipy.integrate import quad_vec

    def integrand(phase: float) -> Any:
        """Returns the four accelerations at a `phase`."""
        return _accelerations(turn, np.array([phase]))[:, 0]

    integrals, _ = quad_vec(
        integrand,
        0.0,
        2.0,
        epsabs=0.0,
        epsrel=QUADRATURE_TOLERANCE,
        points=(1.0,),  # the slider's acceleration changes its sign there
        limit=MAX_INTERVALS,
    )
    velocity, displacement, omega, angle = map(complex, integrals)
    facing = complex(np.exp(1j * turn.body_angle))
    arm = turn._arm(turn.slider_angle)
    coasting_displacement, coasting_angle, coasting_time = residual_limit(
        turn.capsule, arm, velocity / facing, omega.real
    )
    # C is at -mu r from the combined centre, so a further turn moves C round that centre.
    arm = arm * facing
    angle_at_rest = angle.real + coasting_angle
    at_stop = displacement - 1j * arm * angle.real
    at_rest = displacement + facing * coasting_displacement - 1j * arm * angle_at_rest
    velocity_of_c = velocity - 1j * arm * omega.real
    return TurnCorrection(
        at_stop=np.array([at_stop.real, at_stop.imag, angle.real]),
        at_rest=np.array([at_rest.real, at_rest.imag, angle_at_rest]),
        rate_coefficients=np.array([velocity_of_c.real, velocity_of_c.imag, omega.real]),
        residual_time=coasting_time,
    )


def _accelerations(turn: TurnManoeuvre, phases: Array) -> ComplexForces:
    """Returns four accelerations by friction at `phases`, shape (4, n): of the combined centre, and
    the angular one; each is followed by its product with the remaining time (2 - phase), whose
    integral is the displacement or the angle."""
    fraction = angle_fraction(phases)
    capsule = turn.capsule
    force, moment = leading_friction(turn, turn.start + turn.slider_angle * fraction)
    mass = capsule.body_mass + capsule.slider_mass
    acceleration = force * np.exp(1j * turn.body_angle * fraction) / mass
    angular_acceleration = moment / turn.inertia
    remaining = 2.0 - phases
    return np.stack(
        [
            acceleration,
            remaining * acceleration,
            angular_acceleration + 0j,
            remaining * angular_acceleration,
        ]
    )


def residual_limit(
    capsule: Capsule, arm: complex, velocity: complex, omega: float
) -> tuple[complex, float, float]:
    """Returns how far a body coasts from a slow motion: the displacement of its combined centre and
    its turn, both over lambda^2, and the time to rest over lambda, in the limit lambda -> 0. The
    body starts with lambda times `velocity` and `omega`.

    `arm` mu r [m] in body axes; `velocity` of the combined centre [m/s^2], complex, body axes;
    `omega` [rad/s^2]: each per second of tau. In the limit the body does not turn while it stops,
    and friction depends only on the direction of (velocity, omega). So the displacement is
    homogeneous of degree two.
    """
    lever = float(max(abs(complex(*point) - arm) for point in capsule.supports))
    speed = abs(velocity) + lever * abs(omega)
    if speed == 0.0:
        return 0j, 0.0, 0.0
    # A stop from speed v turns the body by about v^2/(f g lever).
    square = NEGLECTED_TURN_ROOT**2 * capsule.friction * capsule.gravity * lever
    scale = float(np.sqrt(square)) / speed  # lambda
    velocity_of_c = scale * (velocity - 1j * omega * arm)
    start = InitialVelocities((velocity_of_c.real, velocity_of_c.imag), scale * omega)
    slider = arm / capsule.mass_ratio
    motion = three_point_motion(capsule, fixed((slider.real, slider.imag)), start)
    end = motion.at(np.array([motion.rest_time]))
    turn = float(end.heading[0])
    displacement = complex(*end.position[0]) + arm * np.expm1(1j * turn)
    return displacement / scale**2, turn / scale**2, motion.rest_time / scale
