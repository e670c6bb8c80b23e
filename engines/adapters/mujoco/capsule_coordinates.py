"""The capsule's observables in MuJoCo's coordinates, and its start in them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.mujoco.capsule_rest import heading, turned
from plumbob.engines.adapters.mujoco.translation import Named

Observe = Callable[[Array, Array], tuple[Named, Named]]
FREE = 7  # least number of coordinates of the full model: place and quaternion; a planar has 5


def start(setup: CapsuleSetup, rest: Array) -> tuple[Array, Array]:
    """qpos, shape (nq,), and qvel, shape (nv,), of a body at `rest`, shape (nq,), turned by the
    heading, with the velocities of the start."""
    qpos = np.array(rest)
    if len(rest) >= FREE:
        qpos[3:7] = turned(rest[3:7], setup.heading)
    else:
        qpos[3] = setup.heading
    vx, vy = _rotated(*setup.velocity, setup.heading)
    turn = [0.0, 0.0, setup.heading_rate] if len(rest) >= FREE else [setup.heading_rate]
    slider = [0.0] if setup.relative_velocity is not None else []
    slider = slider if setup.plane_velocity is None else [0.0, 0.0]
    return qpos, np.array([vx, vy, 0.0, *turn, *slider])


def along(setup: CapsuleSetup, rest: Array) -> Observe:
    """What is signed along the line: displacement, velocity, slider, heading, sideways."""
    line, driven = -(setup.heading + setup.direction), setup.relative_velocity is not None

    def observe(qpos: Array, qvel: Array) -> tuple[Named, Named]:
        gone, sideways = _rotated(qpos[:, 0], qpos[:, 1], line)
        velocity, _ = _rotated(qvel[:, 0], qvel[:, 1], line)
        still = np.zeros_like(gone)
        slid, rate = (qpos[:, -1], qvel[:, -1]) if driven else (still, still)
        return {
            "displacement": gone,
            "velocity": velocity,
            "stroke": slid,
            "stroke_rate": rate,
            "heading": _turn(qpos, setup.heading),
            "sideways": sideways,
        }, {"heave": qpos[:, 2] - rest[2]}

    return observe


def plane(setup: CapsuleSetup, rest: Array) -> Observe:
    """Place of C and heading, which is also the source's body angle, in the axes of the start."""

    def observe(qpos: Array, qvel: Array) -> tuple[Named, Named]:
        x, y = _rotated(qpos[:, 0], qpos[:, 1], -setup.heading)
        vx, vy = _rotated(qvel[:, 0], qvel[:, 1], -setup.heading)
        rate = qvel[:, 5] if qpos.shape[1] >= FREE else qvel[:, 3]
        turn = _turn(qpos, setup.heading)
        seen = {"x": x, "y": y, "velocity_x": vx, "velocity_y": vy}
        seen |= {"heading": turn, "heading_rate": rate, "body_angle": turn}
        return seen, {"heave": qpos[:, 2] - rest[2]}

    return observe


def _turn(qpos: Array, since: float) -> Array:
    """Angle turned since the heading was `since` [rad], at the first of the samples."""
    if qpos.shape[1] < FREE:
        return np.asarray(qpos[:, 3] - since)
    angles = np.unwrap(heading(qpos[:, 3:7])) - since
    return np.asarray(angles - 2 * np.pi * np.round(angles[0] / (2 * np.pi)))


def _rotated(x: Array | float, y: Array | float, angle: float) -> tuple[Array, Array]:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.asarray(cos * x - sin * y), np.asarray(sin * x + cos * y)
