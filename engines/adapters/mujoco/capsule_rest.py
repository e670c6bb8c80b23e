"""Where a body rests on contacts that yield: the start of a run on them."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np

from plumbob.analytic.reference import Array

SETTLING = 1000  # steps: over a hundred periods of `coulomb` contacts
SHIPPED_STEP = 1e-3  # [s], for contacts with a time constant of their own, 0.02 s as shipped


def settled(
    spec: mujoco.MjSpec, tune: Callable[[mujoco.MjModel], None], press: float, step: float
) -> Array:
    """Coordinates at rest under gravity of `press` [m/s^2] alone, shape (nq,), with the first two
    and any turn about the vertical at zero: a run from elsewhere begins with a drop."""
    resting = spec.copy()
    resting.option.gravity = [0.0, 0.0, -press]
    resting.option.timestep = step
    model = resting.compile()
    tune(model)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=SETTLING)
    rest = np.array(data.qpos)
    rest[:2] = 0.0
    if model.nq > model.nv:  # a free joint, its attitude a quaternion
        rest[3:7] = turned(rest[3:7], -float(heading(rest[3:7])))
        rest[7:] = 0.0
    else:
        rest[3:] = 0.0
    return rest


def heading(attitude: Array) -> Array:
    """Angle about the vertical [rad] of quaternions, shape (..., 4): shape (...)."""
    w, x, y, z = np.moveaxis(np.asarray(attitude, dtype=np.float64), -1, 0)
    return np.asarray(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def turned(attitude: Array, angle: float) -> Array:
    """The quaternion `attitude`, shape (4,), turned by `angle` [rad] about the vertical."""
    cos, sin = math.cos(0.5 * angle), math.sin(0.5 * angle)
    w, x, y, z = attitude
    return np.array([cos * w - sin * z, cos * x - sin * y, cos * y + sin * x, cos * z + sin * w])
