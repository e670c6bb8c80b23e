"""The simple pendulum and its linear companion in MuJoCo's terms: the file with their numbers.

The linear one has the same hinge, with a spring in place of gravity, and no force along its rod.
"""

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
    """Translate a pendulum; `problem` is a SimplePendulum. The setting `reads_acceleration` puts an
    accelerometer at the bob of one with a rod."""
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
    """Errors over `duration` [s] from the moment of inertia of the bob, which should be a point."""
    return bob_errors(problem, duration)


def _add_accelerometer(spec: mujoco.MjSpec, length: float) -> None:
    spec.body("bob").add_site(name="bob", pos=[0.0, 0.0, -length])
    kind = mujoco.mjtSensor.mjSENS_ACCELEROMETER
    place = mujoco.mjtObj.mjOBJ_SITE
    spec.add_sensor(name="acceleration", type=kind, objtype=place, objname="bob")


def _readings(sensors: Array) -> Observed:
    """The tension along the rod [N]; and the readings of the accelerometer, if there is one, across
    the rod, towards greater theta, and along it, towards the axis [m/s^2]."""
    if sensors.shape[1] == 3:
        return {"tension": sensors[:, 2]}, {}
    readings = {"acceleration_across": sensors[:, 3], "acceleration_along": sensors[:, 5]}
    return {"tension": sensors[:, 2]}, readings
