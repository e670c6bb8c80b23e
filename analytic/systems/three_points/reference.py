"""The body's motion in the plane as a reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF
from plumbob.analytic.reference import Array, LinearResponse, Signals, remembered
from plumbob.analytic.systems.capsule import (
    NORMAL_FORCES,
    by_support,
    normal_force_uncertainty,
    normal_forces,
)
from plumbob.analytic.systems.three_points.friction import InitialVelocities

# relative rounding of parameters, times and the change of axes
REFERENCE_ROUNDING = 8 * ROUNDOFF
# The stated error is this factor times the difference from a coarser computation. In one motion in
# sixty both computations happen to have similar errors. At some times the difference is then no
# larger than the error at other times.
ERROR_FACTOR = 2.0


@dataclass(frozen=True, eq=False)
class PlaneReference(LinearResponse):
    """Observables of a body's motion in the plane. C starts at the origin, with heading 0."""

    motion: Any
    """A ThreePointMotion or a RepeatedTurn: it has a capsule, a path, poses and an error."""
    error_factor: float = ERROR_FACTOR
    """Factor on the motion's error in the uncertainty of a pose. Stencils use the factor 1: they
    measure how much the error varies from one neighbour to another."""
    closed_form: ClassVar[None] = None  # the motion is integrated from event to event

    @remembered
    def observe(self, times: Array) -> Signals:
        """Exact x, y of C [m], velocity_x, velocity_y [m/s], heading [rad], heading_rate [rad/s]
        and normal_force_1..3 [N] at `times` [s], shape (n,). body_angle equals heading: it is the
        name in the source."""
        pose = self.motion.at(times)
        x, y = pose.position.T
        velocity_x, velocity_y = pose.velocity.T
        places = self.motion.path.places(times)
        return {
            "body_angle": pose.heading,
            "x": x,
            "y": y,
            "velocity_x": velocity_x,
            "velocity_y": velocity_y,
            "heading": pose.heading,
            "heading_rate": pose.angular_velocity,
            **by_support(normal_forces(self.motion.capsule, places)),
        }

    def uncertainty(self, times: Array) -> Signals:
        """Bound on the error of each observable at `times` [s], shape (n,), by the motion's error
        and by rounded inputs."""
        error = self.motion.error
        x, y = error.position[0]
        velocity_x, velocity_y = error.velocity[0]
        pose_errors = {
            "body_angle": error.heading[0],
            "x": x,
            "y": y,
            "velocity_x": velocity_x,
            "velocity_y": velocity_y,
            "heading": error.heading[0],
            "heading_rate": error.angular_velocity[0],
        }
        bounds = {name: self.error_factor * float(part) for name, part in pose_errors.items()}
        bounds |= dict.fromkeys(NORMAL_FORCES, self._load_uncertainty(times))
        uncertainty = {}
        for name, values in self.observe(times).items():
            rounding = REFERENCE_ROUNDING * float(np.abs(values).max())
            uncertainty[name] = np.full(np.shape(times), bounds[name] + rounding)
        return uncertainty

    def _load_uncertainty(self, times: Array) -> float:
        """Bound on the error of each N_i [N], by its arithmetic and by rounded times, which move
        the slider."""
        capsule = self.motion.capsule
        places, velocities, _ = self.motion.path.kinematics(times)
        time_rounding = REFERENCE_ROUNDING * float(np.max(np.abs(times)))
        displacement = time_rounding * float(np.hypot(*velocities.T).max())
        reach = float(np.hypot(*places.T).max())
        return float(normal_force_uncertainty(capsule, reach, displacement))

    @property
    def start(self) -> InitialVelocities:
        """The initial velocity of C and the initial angular velocity."""
        first = self.motion.at(np.zeros(1))
        x, y = first.velocity[0].tolist()
        return InitialVelocities((x, y), float(first.angular_velocity[0]))
