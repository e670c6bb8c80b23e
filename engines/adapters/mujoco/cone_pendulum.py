"""The cone pendulum in MuJoCo's terms: the model's file with a problem's numbers in it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.errors.contact_models.driven_platform import platform_error
from plumbob.analytic.parameters import finite
from plumbob.analytic.reference import Array
from plumbob.engines.adapters.divergence import limits_on_platform
from plumbob.engines.adapters.mujoco.translation import (
    Observed,
    Translation,
    at_start,
    bare,
    read,
)
from plumbob.engines.method import Method, ModelError

# Least ratio of the platform's armature to the inertia it carries: the platform keeps its rate to
# the last bit, and the error that the armature adds stays below the round-off of double precision.
ARMATURE_RATIO = 1e15


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a cone pendulum; `problem` is a ConePendulum. Settings of the method that change
    the model: `platform_armature` [kg m^2] in place of one that keeps the rate to the last bit,
    `drive_rate` [1/s] at which a drive brings the rate of such a platform back to the one
    prescribed, and `reads_energy`, for MuJoCo's own energies."""
    problem, settings = problem.started, method.settings
    spec = whole(mjcf, problem, settings.get("platform_armature"))
    control = _drive(spec, problem, settings["drive_rate"]) if "drive_rate" in settings else None
    return at_start(
        bare(spec),
        _observe,
        limits=limits_on_platform(problem),
        control=control,
        sensors=_named_energies if settings.get("reads_energy") else None,
        probe=_energies,
    )


def _drive(spec: mujoco.MjSpec, problem: Any, rate: float) -> Callable[[Any], Array]:
    """A velocity servo on the platform, and its control: the rate prescribed."""
    gain = rate * spec.joint("platform").armature
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


def whole(mjcf: Path, problem: Any, platform_armature: float | None = None) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, geoms and keyframe included;
    `platform_armature` [kg m^2] is what `armature` says unless given."""
    spec, body = read(mjcf, problem.gravity), problem.body
    hung, offset = spec.body("cone"), body.mass * body.com_distance**2
    spec.joint("platform").armature = platform_armature or armature(problem)
    hung.pos = [problem.pivot_x, problem.pivot_y, problem.pivot_z]
    hung.mass = body.mass
    hung.ipos = [0.0, 0.0, -body.com_distance]
    # about the centre of mass, by the parallel axis theorem
    moments = [body.inertia_x - offset, body.inertia_y - offset, body.inertia_z]
    if body.inertia_yz:  # MuJoCo then works out the principal axes
        hung.inertia = [0.0, 0.0, 0.0]
        hung.fullinertia = [*moments, 0.0, 0.0, body.inertia_yz]
    else:
        hung.inertia = moments
    start = spec.key("start")
    start.qpos = [0.0, finite("theta", problem.theta)]
    start.qvel = [problem.platform_rate, finite("theta_dot", problem.theta_dot)]
    return spec


def load_inertia(problem: Any) -> float:
    """A bound on the body's moment of inertia about the platform's axis [kg m^2], at any angle."""
    body = problem.body
    reach = problem.pivot_x**2 + (abs(problem.pivot_y) + body.com_distance) ** 2
    across = body.inertia_y - body.mass * body.com_distance**2
    return float(body.mass * reach + max(across, body.inertia_z) + abs(body.inertia_yz))


def armature(problem: Any) -> float:
    """Armature of the platform's hinge [kg m^2]: a power of ten, at least ARMATURE_RATIO times the
    load."""
    return float(10.0 ** math.ceil(math.log10(ARMATURE_RATIO * load_inertia(problem))))


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Errors from the platform's finite armature over `duration` [s]: it does not quite keep its
    rate."""
    theta, theta_dot = platform_error(problem.started, duration, armature(problem))
    return {"theta": {"armature": theta}, "theta_dot": {"armature": theta_dot}}


def _observe(qpos: Array, qvel: Array) -> Observed:
    return {"theta": qpos[:, 1], "theta_dot": qvel[:, 1]}, {"platform_rate": qvel[:, 0]}


def _named_energies(energies: Array) -> Observed:
    return {}, {"potential": energies[:, 0], "kinetic": energies[:, 1]}
