"""The simple pendulum in MuJoCo's terms: the model's file with a problem's numbers in it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.rod_tension import MASS
from plumbob.engines.adapters.divergence import limits
from plumbob.engines.adapters.mujoco.translation import Named, Translation, read
from plumbob.engines.method import Method

POINT = 1e-15  # [kg m^2] of the bob: the least moment of inertia that MuJoCo takes
_ULP = 2.0**-52


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a pendulum; `problem` is a SimplePendulum."""
    problem = problem.started
    spec = whole(mjcf, problem)
    for shown in tuple(spec.geoms):  # seen, not felt: without them a step costs less
        spec.delete(shown)
    driven = problem.forcing_amplitude != 0.0
    if not driven:
        spec.delete(spec.actuator("forcing"))
    return Translation(
        spec,
        qpos=np.array([problem.theta]),
        qvel=np.array([problem.theta_dot]),
        observe=_observe,
        limits=limits(problem),
        control=(lambda times: problem.rotor.forcing(times)[:, None]) if driven else None,
        control_at=float(method.settings.get("control_at", 0.0)),
        felt=lambda sensed: {"tension": sensed[:, 2]},  # along the rod
        tune=_unfelt,
    )


def whole(mjcf: Path, problem: Any) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, what is only seen included."""
    problem = problem.started
    spec, length = read(mjcf), problem.length
    moment, bob, joint = MASS * length**2, spec.body("bob"), spec.joint("theta")
    spec.option.gravity = [0.0, 0.0, -problem.gravity]
    bob.ipos = [0.0, 0.0, -length]
    joint.damping = first_coefficient(joint.damping, problem.damping_rate * moment)
    spec.actuator("forcing").gear[0] = moment
    spec.geom("rod").fromto = [0.0, 0.0, -length, 0.0, 0.0, 0.0]
    spec.geom("bob").pos = [0.0, 0.0, -length]
    start = spec.key("start")
    start.qpos, start.qvel = [problem.theta], [problem.theta_dot]
    return spec


def first_coefficient(template: Any, value: float) -> Any:
    """`value` in the shape of a joint's damping or stiffness: a number, or since MuJoCo 3.17 the
    coefficients of a polynomial, constant first."""
    if np.ndim(template) == 0:
        return value
    return [value, *[0.0] * (len(template) - 1)]


@lru_cache(maxsize=64)  # every method and step of a scene asks for the same
def _moment_share(problem: Any, duration: float) -> Mapping[str, Mapping[str, float]]:
    times = np.linspace(0.0, duration, 200)
    ulps = POINT / (MASS * problem.length**2) / _ULP
    doubts = problem.motion.uncertainty(times)
    return {name: {"moment of the bob": ulps * doubt.max()} for name, doubt in doubts.items()}


def model_error(
    problem: Any, duration: float, method: Method, step: float
) -> Mapping[str, Mapping[str, float]]:
    """What the moment of inertia of the bob, which is to be a point, adds over `duration` [s]: a
    moment larger by so many units in the last place does what as many in every input would."""
    return _moment_share(problem, duration)


def _observe(qpos: Array, qvel: Array) -> tuple[Named, Named]:
    return {"theta": qpos[:, 0], "theta_dot": qvel[:, 0]}, {}


def _unfelt(model: mujoco.MjModel) -> None:
    """Leave the sensor out of the steps: it is read at the samples alone."""
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
