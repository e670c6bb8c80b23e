"""The cone pendulum in MuJoCo: the model file with the numbers of a problem."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.translation import (
    Observed,
    Translation,
    at_start,
    bare,
    filled,
)
from plumbob.engines.adapters.pendulum_errors import platform_errors
from plumbob.engines.method import Method, ModelError
from plumbob.models.cone_pendulum.model import MODEL


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """The translation of a ConePendulum. Three settings of a method change the model:

    - `platform_armature` [kg m^2] replaces the armature that keeps the platform's rate to the last
      bit;
    - `drive_rate` [1/s] adds a drive that returns the platform to the prescribed rate;
    - `reads_energy` records the energies that MuJoCo computes.
    """
    problem = problem.started
    settings = method.settings
    spec = filled(mjcf, MODEL, problem)
    if "platform_armature" in settings:
        spec.joint("platform").armature = settings["platform_armature"]
    control = (
        _drive(spec, problem, settings["drive_rate"]) if "drive_rate" in settings else None
    )
    return at_start(
        bare(spec),
        channels=lambda qpos, qvel: {"platform_rate": qvel[:, 0]},
        control=control,
        sensors=_named_energies if settings.get("reads_energy") else None,
        probe=_energies,
    )


def _drive(spec: mujoco.MjSpec, problem: Any, bandwidth: float) -> Callable[[Any], Array]:
    """Adds a velocity servo to the platform, whose gain is `bandwidth` [1/s] times the platform's
    armature. Returns a function from times [s], shape (n,), to the servo's control, shape (n, 1),
    which is the prescribed rate."""
    gain = bandwidth * spec.joint("platform").armature
    servo = spec.add_actuator(name="drive", target="platform")
    servo.trntype = mujoco.mjtTrn.mjTRN_JOINT
    servo.set_to_velocity(kv=gain)
    spec.option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    return lambda times: np.full((len(times), 1), problem.platform_rate)


def _energies(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """The potential and kinetic energy that MuJoCo computes [J], with the platform."""
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    return np.array(data.energy)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds on errors over `duration` [s]: with a finite armature the platform does not quite keep
    its rate."""
    return platform_errors(problem.started, duration)


def _named_energies(energies: Array) -> Observed:
    """The energies of samples, shape (n, 2), as channels."""
    return {}, {"potential": energies[:, 0], "kinetic": energies[:, 1]}
