"""A motion of the body in the plane as a reference."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, ClassVar

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.reference import Array, LinearResponse, Signals
from plumbob.analytic.systems.capsule import (
    by_support,
    normal_force_uncertainty,
    normal_forces,
)
from plumbob.analytic.systems.three_points.friction import Start

ROUNDINGS = 8 * ROUNDOFF  # of parameters and times, and of the change to the axes of the start


@dataclass(frozen=True)
class PlaneReference(LinearResponse):
    """Observables of a motion in the plane: C starts at the origin, with heading 0."""

    motion: Any
    """A ThreePointMotion, or several equal ones: its body, path, pose at any time, and error."""
    closed_form: ClassVar[None] = None  # integrated from event to event

    def observe(self, times: Array) -> Signals:
        """Exact x, y of C [m], velocity_x, velocity_y [m/s], heading [rad], heading_rate [rad/s]
        and normal_force_1..3 [N] at `times` [s], shape (n,); body_angle is the heading by the
        source's name."""
        return dict(self._observed(np.asarray(times, dtype=np.float64).tobytes()))

    @cached_property
    def _observed(self) -> Callable[[bytes], Signals]:
        """Observables at times given as bytes, read-only: methods and steps share their samples,
        and an error, its uncertainty and its prediction are of the same ones."""

        @lru_cache(maxsize=16)
        def found(times: bytes) -> Signals:
            observed = self._worked_out(np.frombuffer(times))
            for values in observed.values():
                values.setflags(write=False)
            return observed

        return found

    def _worked_out(self, times: Array) -> Signals:
        now = self.motion.at(times)
        (x, y), (velocity_x, velocity_y) = now.position.T, now.velocity.T
        return {
            "body_angle": now.heading,
            "x": x,
            "y": y,
            "velocity_x": velocity_x,
            "velocity_y": velocity_y,
            "heading": now.heading,
            "heading_rate": now.angular_velocity,
            **by_support(normal_forces(self.motion.capsule, self.motion.path.places(times))),
        }

    def uncertainty(self, times: Array) -> Signals:
        """The error of the motion, and that of rounded inputs, at `times` [s], shape (n,)."""
        error, observed = self.motion.error, self.observe(times)
        heading, rate = float(error.heading[0]), float(error.angular_velocity[0])
        load = self._load_uncertainty(times)
        bounds = (heading, *error.position[0], *error.velocity[0], heading, rate, *3 * (load,))
        return {
            name: np.full(np.shape(times), bound + ROUNDINGS * float(np.abs(values).max()))
            for (name, values), bound in zip(observed.items(), bounds, strict=True)
        }

    def _load_uncertainty(self, times: Array) -> float:
        """Of each N_i [N]: its arithmetic, and the times at which the slider is where it is."""
        capsule, (places, speeds, _) = self.motion.capsule, self.motion.path.kinematics(times)
        late = ROUNDINGS * float(np.max(np.abs(times))) * float(np.hypot(*speeds.T).max())
        reach = float(np.hypot(*places.T).max())
        return float(normal_force_uncertainty(capsule, reach, late))

    @property
    def begun(self) -> Start:
        """How the body moves at first."""
        first = self.motion.at(np.zeros(1))
        x, y = first.velocity[0].tolist()
        return Start((x, y), float(first.angular_velocity[0]))
