"""The observables of a capsule, from its pose or from the coordinates of its model."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup

UNREACHED_RATIO = 1e3  # ratio of a distance to the capsule's size that no sliding body reaches


@dataclass(frozen=True)
class ChainPose:
    """The pose of a chain of bodies, and its rates: place and heading of the first body in the
    world, and the coordinate of the last joint from its start. The values are numbers, or have
    shape (n,) each. Places and velocities are x + iy."""

    place: Any  # [m]
    velocity: Any  # [m/s]
    heading: Any  # [rad], whole turns included
    heading_rate: Any  # [rad/s]
    joint: Any = 0.0  # [m] or [rad]
    joint_rate: Any = 0.0  # [m/s] or [rad/s]


def start_velocity(setup: CapsuleSetup) -> tuple[float, float]:
    """Returns the velocity of C at the start, in the world [m/s]."""
    velocity = complex(*setup.velocity) * cmath.rect(1.0, setup.heading)
    return velocity.real, velocity.imag


def largest_magnitudes(setup: CapsuleSetup) -> Mapping[str, float]:
    """Returns magnitudes of observables that only a diverged run exceeds."""
    size = float(np.abs(setup.capsule.supports).max())
    return dict.fromkeys(("displacement", "x", "y"), UNREACHED_RATIO * size)


def observe(problem: CapsuleProblem, qpos: Array, qvel: Array) -> Signals:
    """Returns the observables that the coordinates of a free body and of its slider show: the place
    and velocity of C, and the slider's stroke if it keeps to a line."""
    setup = problem.setup
    stroke = np.zeros(len(qpos))
    stroke_rate = np.zeros(len(qpos))
    if setup.relative_velocity is not None:
        stroke[:] = qpos[:, -1]
        stroke_rate[:] = qvel[:, -1]
    as_complex = np.array([1.0, 1.0j])
    place = qpos[:, :2] @ as_complex
    velocity = qvel[:, :2] @ as_complex
    # An attitude gives the angle up to whole turns.
    angles = np.unwrap(heading_of_attitude(qpos[:, 3:7]))
    turns = nearest_turn(angles[0], setup.heading) - angles[0]
    pose = ChainPose(place, velocity, angles + turns, qvel[:, 5], stroke, stroke_rate)
    return pose_observables(setup, pose)


def pose_observables(setup: CapsuleSetup, pose: ChainPose) -> dict[str, Any]:
    """Returns the observables that a pose shows: all but the forces."""
    axis = setup.heading + (0.0 if setup.in_plane else setup.direction)
    to_axis = cmath.rect(1.0, -axis)
    place = pose.place * to_axis
    velocity = pose.velocity * to_axis
    if setup.in_plane:
        return {
            "x": place.real,
            "y": place.imag,
            "velocity_x": velocity.real,
            "velocity_y": velocity.imag,
            "heading": pose.heading,
            "heading_rate": pose.heading_rate,
            "body_angle": pose.heading - setup.heading,
        }
    return {
        "displacement": place.real,
        "velocity": velocity.real,
        "stroke": pose.joint,
        "stroke_rate": pose.joint_rate,
        "heading": pose.heading,
        "sideways": place.imag,
    }


def observed_on_a_line(
    setup: CapsuleSetup, place: Any, velocity: Any, stroke: Any, stroke_rate: Any
) -> dict[str, Any]:
    """Returns the observables of a model that keeps to the line.

    `place` is the place of C on the line [m], `velocity` its velocity [m/s]. `stroke` is the
    slider's way in the body from its start [m], `stroke_rate` its rate [m/s]. The model itself
    fixes the heading and the distance across the line.
    """
    if not setup.in_plane:
        names = ("displacement", "velocity", "stroke", "stroke_rate")
        return dict(zip(names, (place, velocity, stroke, stroke_rate), strict=True))
    x = math.cos(setup.direction)
    y = math.sin(setup.direction)
    places = {"x": x * place, "y": y * place}
    return {**places, "velocity_x": x * velocity, "velocity_y": y * velocity}


def heading_of_attitude(attitude: Array) -> Array:
    """Returns the angle about the vertical [rad], shape (...), of quaternions, shape (..., 4)."""
    w, x, y, z = np.moveaxis(np.asarray(attitude, dtype=np.float64), -1, 0)
    return np.asarray(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def nearest_turn(angle: float, before: float) -> float:
    """Returns the angle [rad] nearest to `before` [rad] that differs from `angle` by whole
    turns."""
    return angle + 2.0 * math.pi * float(np.rint((before - angle) / (2.0 * math.pi)))
