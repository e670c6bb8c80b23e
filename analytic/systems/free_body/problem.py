"""The free rigid body as a problem: its parameters, its exact motion and the uncertainty of that
motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP, varied
from plumbob.analytic.numerics.quad import double, quad
from plumbob.analytic.parameters import ParameterError, finite, positive
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.free_body.rotation import (
    ANGULAR_VELOCITY_NAMES,
    ATTITUDE,
    Rotation,
    RotationConstants,
)

# For a difference quotient, the relative change of an input is the square of RELATIVE_CHANGE times
# the smaller of two numbers. The response is then linear. The numbers are the distance from the
# separatrix (1 far from it), and SHORT_ANGLE/(SHORT_ANGLE + angle) for the turn's angle [rad].
RELATIVE_CHANGE = 1e-4
SHORT_ANGLE = 100.0
# Rounding of the closed form in units in the last place. An attitude is the product of three turns,
# with one unit each. A component of the angular momentum has some six roundings of half a unit of
# its largest size.
FREE_BODY_ROUNDINGS = 3.0
INERTIA_NAMES = ("inertia_x", "inertia_y", "inertia_z")


@dataclass(frozen=True)
class FreeBody:
    """A rigid body without any force on it: its principal moments of inertia [kg m^2], and its
    angular velocity [rad/s] at time 0, three numbers along its axes. At time 0 its axes are the
    world's. Raises ParameterError, also for moments that no rigid body has.

    >>> import numpy as np
    >>> body = FreeBody(1.0, 2.0, 2.5, (0.01, 2.0, 0.0))
    >>> seen = body.observe(np.array([0.0, body.half_period]))
    >>> print(f"{body.half_period:.4f} s, {seen['angular_velocity_y'][1]:.4f} rad/s: turned over")
    14.4938 s, -2.0000 rad/s: turned over
    """

    inertia_x: float
    inertia_y: float
    inertia_z: float
    angular_velocity: Sequence[float]

    def __post_init__(self) -> None:
        for name in INERTIA_NAMES:
            positive(name, getattr(self, name))
        for name in INERTIA_NAMES:
            moment = getattr(self, name)
            others = sum(map(quad, self.inertia)) - quad(moment)
            if quad(moment) > others:
                need = "at most the sum of the other two moments, as of every rigid body"
                raise ParameterError(name, moment, need)
        rates: Any = self.angular_velocity
        need = "three finite numbers: [x, y, z]"
        if isinstance(rates, str) or not isinstance(rates, Sequence) or len(rates) != 3:
            raise ParameterError("angular_velocity", rates, need)
        try:
            numbers = tuple(finite("angular_velocity", value) for value in rates)
        except ParameterError:
            raise ParameterError("angular_velocity", rates, need) from None
        object.__setattr__(self, "angular_velocity", numbers)

    @property
    def inertia(self) -> tuple[float, float, float]:
        """The three principal moments of inertia [kg m^2]."""
        return self.inertia_x, self.inertia_y, self.inertia_z

    @cached_property
    def rotation(self) -> Rotation:
        """The exact rotation, with 34 digits."""
        return Rotation(quad(self.inertia), quad(self.angular_velocity))

    @property
    def speed(self) -> float:
        """Magnitude of the angular velocity [rad/s] at time 0."""
        return math.hypot(*self.angular_velocity)

    @property
    def fastest(self) -> float:
        """A bound on the angular velocity [rad/s] of all motions with this angular momentum."""
        return float(double(self.rotation.magnitude)) / min(self.inertia)

    @property
    def half_period(self) -> float:
        """Time [s] after which the angular velocity about the axis of the intermediate moment of
        inertia, and about one other axis, have changed sign; infinite if they never do."""
        constants = self.rotation.constants
        return math.inf if constants is None else float(double(constants.half_turn))

    @property
    def kind(
        self,
    ) -> Literal["steady", "separatrix", "about the largest", "about the smallest"]:
        """The kind of motion: steady, on the separatrix, or about the axis of the largest or the
        smallest moment of inertia."""
        constants = self.rotation.constants
        if constants is None:
            return "steady"
        if constants.b == 0:
            return "separatrix"
        about_largest = self.inertia[constants.axes[0]] == max(self.inertia)
        return "about the largest" if about_largest else "about the smallest"

    def observe(self, times: Array) -> Signals:
        """Exact angular velocity [rad/s] in the body's axes, and attitude, a unit quaternion from
        body to world, at `times` [s], shape (n,). The quaternion is continuous and starts at 1."""
        return dict(
            zip((*ANGULAR_VELOCITY_NAMES, *ATTITUDE), self.rotation.state(times), strict=True)
        )

    def uncertainty(self, times: Array) -> Signals:
        """Change of each observable at `times` [s], shape (n,), by rounding: by one unit in the
        last place of every input, of the times, and of the angular momentum where it is nearest to
        an axis. The rounding of the closed form itself is added.

        The rounding of the angular momentum is needed near the unstable axis: the start has small
        components, whose roundings are small, but roundings at later times are larger.
        """
        rotation = self.rotation
        times = np.asarray(times, dtype=np.float64)
        states = rotation.state(times)
        errors = self._arithmetic_rounding(times, states[:3])
        change = self._change(times)
        for neighbour in varied(rotation, change):
            errors += np.abs(neighbour.state(times) - states) * (ULP / change)
        if rotation.constants is not None:
            errors += self._later_rounding(rotation.constants, times, change)
        return dict(zip((*ANGULAR_VELOCITY_NAMES, *ATTITUDE), errors, strict=True))

    def _arithmetic_rounding(self, times: Array, rates: Array) -> Array:
        """Bound on the effect of rounded times and of the closed form's arithmetic, shape (7, n):
        three rows for the angular velocity [rad/s], which is `rates`, shape (3, n), and four for
        the quaternion."""
        late = ULP * np.abs(times)  # [s] rounding of the times
        errors = np.zeros((7, len(times)))
        errors[3:] = FREE_BODY_ROUNDINGS * ULP + late * np.sqrt((rates**2).sum(axis=0)) / 2
        constants = self.rotation.constants
        if constants is None:
            return errors
        inertia = double(self.rotation.inertia)[:, None]
        torque = np.abs(np.cross(inertia * rates, rates, axis=0))
        start_time = abs(constants.start_time)
        late += ULP * (
            start_time + np.minimum(self.half_period / 2, start_time + np.abs(times))
        )
        amplitudes = np.empty((3, 1))
        amplitudes[[*constants.axes], 0] = constants.amplitudes
        momentum_error = FREE_BODY_ROUNDINGS * ULP * amplitudes + late * torque
        errors[:3] = momentum_error / inertia
        size = np.sqrt((momentum_error**2).sum(axis=0))
        errors[3:] += size / double(self.rotation.magnitude) / 2
        return errors

    def _change(self, times: Array) -> float:
        """Returns a relative change of the inputs to which the motion responds linearly up to the
        last of `times` [s]; at least ULP.

        The change shrinks with the time. If two moments are nearly equal, their difference makes a
        rate grow evenly, so that the response of the attitude grows as the square of the time.
        """
        constants = self.rotation.constants
        distance = 1.0 if constants is None else float(double(constants.b / constants.a))
        angle = self.fastest * float(np.max(np.abs(times), initial=0.0))
        smaller = min(distance, SHORT_ANGLE / (SHORT_ANGLE + angle))
        return max(ULP, (RELATIVE_CHANGE * smaller) ** 2)

    def _later_rounding(
        self, constants: RotationConstants, times: Array, change: float
    ) -> Array:
        """Returns the change of the state, shape (7, n), by a rounding of each component of the
        angular momentum at the time when the middle component first passes zero. The rounding is
        one unit in the last place of the momentum's magnitude; the response is measured with the
        relative `change`."""
        rotation = self.rotation
        wait = -constants.start_time
        if wait < 0.0 and math.isfinite(self.half_period):
            wait += self.half_period
        # the exact motion from the time of that passage on, and its neighbours
        rates = rotation.state(np.array([wait]))[:3, 0]
        later = Rotation(rotation.inertia, quad(rates))
        elapsed = np.maximum(times - wait, 0.0)
        errors = np.zeros((7, len(times)))
        states = later.state(elapsed)
        rate_changes = np.diag(quad(change) * rotation.magnitude / rotation.inertia)
        for changed_rates in later.rates + rate_changes:
            changed = Rotation(rotation.inertia, changed_rates)
            difference = changed.state(elapsed) - states
            errors[:3] += np.abs(difference[:3]) * (ULP / change)
            errors[3:] += np.sqrt((difference[3:] ** 2).sum(axis=0)) * (ULP / change)
        return errors * (times >= wait)

    def nonlinearity(self, times: Array, errors: Signals) -> float:
        """Nonlinearity of the response to errors of the observables, shape (n,) each. It is the
        largest of the attitude's error angle, the momentum's relative error, and the relative error
        of the momentum's distance from the separatrix."""
        if not self.speed:
            return 0.0
        inertia = np.array(self.inertia)[:, None]
        momentum_error = inertia * np.stack([errors[name] for name in ANGULAR_VELOCITY_NAMES])
        angle_error = 2.0 * np.sqrt(sum(errors[name] ** 2 for name in ATTITUDE))
        error_size = np.sqrt((momentum_error**2).sum(axis=0))
        relative_error = error_size / double(self.rotation.magnitude)
        largest = max(float(np.max(angle_error)), float(relative_error.max()))
        if self.rotation.constants is None:
            return largest
        momentum = inertia * self.rotation.state(times)[:3]
        # Weights of the energy relative to the separatrix's, where the middle axis adds nothing.
        weights = 1.0 / np.median(inertia) - 1.0 / inertia
        drift = (weights * momentum * momentum_error).sum(axis=0)
        size = (np.abs(weights) * momentum**2).sum(axis=0)
        return max(largest, float(np.max(2.0 * np.abs(drift) / size)))

    def invariants(self, observed: Signals) -> Signals:
        """Returns the relative drifts, shape (n,), of the energy and of the angular momentum's
        magnitude, and the change of the momentum's direction in the world since time 0, from
        observables of shape (n,)."""
        rates = np.stack([observed[name] for name in ANGULAR_VELOCITY_NAMES])
        inertia = np.array(self.inertia)[:, None]
        momentum = inertia * rates
        energy = (inertia * rates**2).sum(axis=0)
        size = np.sqrt((momentum**2).sum(axis=0))
        if not size[0]:
            return {}
        drifts = {"energy": energy / energy[0] - 1.0, "momentum": size / size[0] - 1.0}
        if all(name in observed for name in ATTITUDE):
            attitude = np.stack([observed[name] for name in ATTITUDE])
            in_world = vectors_in_world(attitude, momentum)
            change = np.sqrt(((in_world - in_world[:, :1]) ** 2).sum(axis=0))
            drifts["momentum_in_world"] = change / size[0]
        return drifts


def vectors_in_world(attitude: Array, vectors: Array) -> Array:
    """Returns `vectors` in the body's axes, shape (3, n), expressed in the world's axes, by
    quaternions `attitude`, shape (4, n), which are taken to have length 1."""
    scalar = attitude[0]
    axis = attitude[1:]
    normal = np.cross(axis, vectors, axis=0)
    return np.asarray(vectors + 2.0 * (scalar * normal + np.cross(axis, normal, axis=0)))
