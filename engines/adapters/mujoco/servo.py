"""The servo in MuJoCo's terms: a hinge with a position actuator, whose control stays 0."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.simple_pendulum import first_coefficient
from plumbob.engines.adapters.mujoco.translation import Named, Translation, read
from plumbob.engines.method import Method, ModelError

DROPPED = math.sqrt(mujoco.mjMINVAL)  # [N m]: `discrete` leaves out forces of a smaller norm


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a Servo; the hinge's angle is that from the target."""
    spec = whole(mjcf, problem)
    for shown in tuple(spec.geoms):  # without effect, and a step costs less without them
        spec.delete(shown)

    def observe(qpos: Array, qvel: Array) -> tuple[Named, Named]:
        return {"theta": qpos[:, 0], "theta_dot": qvel[:, 0]}, {}

    # A run that reaches a limit which the motion does not has too large a step, and is to diverge.
    spec.actuator("motor").forcelimited = int(problem.saturates)
    start = spec.key("start")
    return Translation(spec, np.array(start.qpos), np.array(start.qvel), observe)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The effect of forces that `discrete` leaves out, by the integral of the response to them."""
    if method.settings["integrator"] != "discrete":
        return {}
    linear = problem.started
    natural, damping = math.sqrt(linear.gravity), linear.damping_rate
    lasting = min(duration, 2.0 / damping) if damping else duration
    angle = DROPPED / linear.mass * (1.0 / natural + lasting) / natural
    reason = "forces below a threshold"
    return {"theta": {reason: angle}, "theta_dot": {reason: angle * natural}}


def whole(mjcf: Path, problem: Any) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, visual parts included."""
    spec = read(mjcf)
    joint, motor, start = spec.joint("theta"), spec.actuator("motor"), spec.key("start")
    spec.body("link").inertia = [problem.inertia] * 3
    joint.armature = problem.armature
    joint.damping = first_coefficient(joint.damping, problem.damping)
    motor.gear[0], motor.gainprm[0] = problem.gear, problem.kp
    motor.biasprm[1:3] = [-problem.kp, -problem.kv]
    motor.forcerange = [-problem.force_limit, problem.force_limit]
    start.qpos, start.qvel = [problem.theta], [problem.theta_dot]
    return spec
