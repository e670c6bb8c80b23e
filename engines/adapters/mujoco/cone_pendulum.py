"""The cone pendulum in MuJoCo's terms: the model's file with a problem's numbers in it."""

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
    """Translate a cone pendulum; `problem` is a ConePendulum. Settings of the method that change
    the model: `platform_armature` [kg m^2] in place of one that keeps the rate to the last bit,
    `drive_rate` [1/s] at which a drive brings the rate of such a platform back to the one
    prescribed, and `reads_energy`, for MuJoCo's own energies."""
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
    """Add a velocity servo to the platform, with a gain of `bandwidth` [1/s] times its armature;
    returns the servo's control at times [s], shape (n,): the prescribed rate, shape (n, 1)."""
    gain = bandwidth * spec.joint("platform").armature
    servo = spec.add_actuator(name="drive", target="platform")
    servo.trntype = mujoco.mjtTrn.mjTRN_JOINT
    servo.set_to_velocity(kv=gain)
    spec.option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    return lambda times: np.full((len(times), 1), problem.platform_rate)


def _energies(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """MuJoCo's potential and kinetic energy [J], the platform's included."""
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    return np.array(data.energy)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Errors from the platform's finite armature over `duration` [s]: it does not quite keep its
    rate."""
    return platform_errors(problem.started, duration)


def _named_energies(energies: Array) -> Observed:
    return {}, {"potential": energies[:, 0], "kinetic": energies[:, 1]}
