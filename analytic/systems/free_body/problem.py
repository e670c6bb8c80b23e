"""The free rigid body as a problem: its parameters, its exact motion, its invariants."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from plumbob.analytic.numerics.quad import double, quad
from plumbob.analytic.parameters import ParameterError, finite, positive
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.free_body import conditioning
from plumbob.analytic.systems.free_body.rotation import ATTITUDE, RATES, Rotation

MOMENTS = ("inertia_x", "inertia_y", "inertia_z")


@dataclass(frozen=True)
class FreeBody:
    """A rigid body without any force on it: its principal moments of inertia [kg m^2], and its
    angular velocity [rad/s], three numbers along its axes, at time 0, when these are the world's.
    Raises ParameterError, also for moments that no rigid body has.

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
        for name in MOMENTS:
            positive(name, getattr(self, name))
        for name in MOMENTS:
            if quad(moment := getattr(self, name)) > sum(map(quad, self.inertia)) - quad(moment):
                wanted = "at most the sum of the other two moments, as of every rigid body"
                raise ParameterError(name, moment, wanted)
        rates: Any = self.angular_velocity
        wanted = "three finite numbers: [x, y, z]"
        if isinstance(rates, str) or not isinstance(rates, Sequence) or len(rates) != 3:
            raise ParameterError("angular_velocity", rates, wanted)
        try:
            numbers = tuple(finite("angular_velocity", value) for value in rates)
        except ParameterError:
            raise ParameterError("angular_velocity", rates, wanted) from None
        object.__setattr__(self, "angular_velocity", numbers)

    @property
    def inertia(self) -> tuple[float, float, float]:
        """The three moments [kg m^2]."""
        return self.inertia_x, self.inertia_y, self.inertia_z

    @cached_property
    def rotation(self) -> Rotation:
        """The exact motion."""
        (a, b, c), (x, y, z) = map(quad, self.inertia), map(quad, self.angular_velocity)
        return Rotation((a, b, c), (x, y, z))

    @property
    def speed(self) -> float:
        """Magnitude of the angular velocity [rad/s] at time 0."""
        return math.hypot(*self.angular_velocity)

    @property
    def fastest(self) -> float:
        """An angular velocity [rad/s] that no motion of this angular momentum exceeds."""
        return float(double(self.rotation.magnitude)) / min(self.inertia)

    @property
    def half_period(self) -> float:
        """Time [s] in which the angular velocity's middle component, and one other, change sign;
        infinite where they never do."""
        turning = self.rotation.turning
        return math.inf if turning is None else float(double(turning.half_turn))

    @property
    def kind(self) -> Literal["steady", "separatrix", "about the largest", "about the smallest"]:
        """The kind of motion: steady, on the separatrix, or about the axis of the largest or the
        smallest moment of inertia."""
        if (turning := self.rotation.turning) is None:
            return "steady"
        if turning.b == 0:
            return "separatrix"
        largest = self.inertia[turning.axes[0]] == max(self.inertia)
        return "about the largest" if largest else "about the smallest"

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Angular velocity [rad/s] in the body's axes and attitude, a unit quaternion from body to
        world, continuous from 1, at `times` [s], shape (n,)."""
        rates, attitude = self.rotation.state(times)
        return dict(zip((*RATES, *ATTITUDE), (*rates, *attitude), strict=True))

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """See `plumbob.analytic.reference.Reference`."""
        return conditioning.uncertainty(self.rotation, times)

    def nonlinearity(self, times: Array, errors: Mapping[str, Array]) -> float:
        """See `plumbob.analytic.reference.Reference`."""
        return conditioning.nonlinearity(self.rotation, times, errors)

    def invariants(self, observed: Mapping[str, Array]) -> Mapping[str, Array]:
        """Relative drifts, shape (n,), of the energy and of the angular momentum's magnitude, and
        the distance of its direction in the world from that at time 0, of observables of shape
        (n,)."""
        rates = np.stack([observed[name] for name in RATES])
        inertia = np.array(self.inertia)[:, None]
        momentum, energy = inertia * rates, (inertia * rates**2).sum(axis=0)
        size = np.sqrt((momentum**2).sum(axis=0))
        if not size[0]:
            return {}
        drifts = {"energy": energy / energy[0] - 1.0, "momentum": size / size[0] - 1.0}
        if all(name in observed for name in ATTITUDE):
            world = turned(np.stack([observed[name] for name in ATTITUDE]), momentum)
            off = np.sqrt(((world - world[:, :1]) ** 2).sum(axis=0))
            drifts["momentum_in_world"] = off / size[0]
        return drifts


def turned(attitude: Array, vectors: Array) -> Array:
    """`vectors` in the body's axes, shape (3, n), as seen in the world, by quaternions `attitude`,
    shape (4, n), taken as of length 1."""
    scalar, part = attitude[0], attitude[1:]
    once = np.cross(part, vectors, axis=0)
    return np.asarray(vectors + 2.0 * (scalar * once + np.cross(part, once, axis=0)))
