"""The simple and the linear pendulum in MuJoCo: the model file with their numbers. The linear one
has a spring in place of gravity."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.translation import (
    Observed,
    Translation,
    at_start,
    bare,
    filled,
)
from plumbob.engines.adapters.pendulum_errors import bob_errors
from plumbob.engines.method import Method, ModelError
from plumbob.models.simple_pendulum.model import MODEL


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """The translation of a SimplePendulum. The setting `reads_acceleration` of a method puts an
    accelerometer at the bob, unless the pendulum is linear."""
    problem = problem.started
    spec = bare(filled(mjcf, MODEL, problem))
    if problem.forcing_amplitude == 0.0:
        spec.delete(spec.actuator("forcing"))
    if problem.linear:
        spec.delete(spec.sensor("rod"))
    elif method.settings.get("reads_acceleration"):
        _add_accelerometer(spec, problem.length)
    return at_start(
        spec,
        control_at=float(method.settings.get("control_at", 0.0)),
        sensors=None if problem.linear else _readings,
    )


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds on errors over `duration` [s] from the moment of inertia of the bob, a point mass."""
    return bob_errors(problem, duration)


def _add_accelerometer(spec: mujoco.MjSpec, length: float) -> None:
    """Adds an accelerometer at the end of the rod."""
    spec.body("bob").add_site(name="bob", pos=[0.0, 0.0, -length])
    kind = mujoco.mjtSensor.mjSENS_ACCELEROMETER
    place = mujoco.mjtObj.mjOBJ_SITE
    spec.add_sensor(name="acceleration", type=kind, objtype=place, objname="bob")


def _readings(sensors: Array) -> Observed:
    """The tension of the rod [N], from sensor data of shape (n, k). If there is an accelerometer,
    its readings are channels: across the rod, toward greater theta, and along the rod, toward the
    axis [m/s^2]."""
    if sensors.shape[1] == 3:
        return {"tension": sensors[:, 2]}, {}
    readings = {"acceleration_across": sensors[:, 3], "acceleration_along": sensors[:, 5]}
    return {"tension": sensors[:, 2]}, readings
