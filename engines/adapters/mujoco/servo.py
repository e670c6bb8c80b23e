"""The servo in MuJoCo's terms: a hinge with a position actuator, whose control stays 0."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco

from plumbob.engines.adapters.mujoco.simple_pendulum import first_coefficient, of_hinge
from plumbob.engines.adapters.mujoco.translation import Translation, at_start, bare, read
from plumbob.engines.method import Method, ModelError

DROPPED = math.sqrt(mujoco.mjMINVAL)  # [N m]: `discrete` leaves out forces of a smaller norm


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a Servo; the hinge's angle is that from the target."""
    spec = bare(whole(mjcf, problem))
    # A run that reaches a limit which the motion does not has too large a step, and is to diverge.
    spec.actuator("motor").forcelimited = int(problem.saturates)
    return at_start(spec, of_hinge)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The effect of forces that `discrete` leaves out, by the integral of the response to them."""
    if method.settings["integrator"] != "discrete":
        return {}
    linear = problem.started
    natural = math.sqrt(linear.gravity)
    damping = linear.damping_rate
    lasting = min(duration, 2.0 / damping) if damping else duration
    angle = DROPPED / linear.mass * (1.0 / natural + lasting) / natural
    reason = "forces below a threshold"
    return {"theta": {reason: angle}, "theta_dot": {reason: angle * natural}}


def whole(mjcf: Path, problem: Any) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, visual parts included."""
    spec = read(mjcf)
    joint = spec.joint("theta")
    motor = spec.actuator("motor")
    start = spec.key("start")
    spec.body("link").inertia = [problem.inertia] * 3
    joint.armature = problem.armature
    joint.damping = first_coefficient(joint.damping, problem.damping)
    motor.gear[0] = problem.gear
    motor.gainprm[0] = problem.kp
    motor.biasprm[1:3] = [-problem.kp, -problem.kv]
    motor.forcerange = [-problem.force_limit, problem.force_limit]
    start.qpos = [problem.theta]
    start.qvel = [problem.theta_dot]
    return spec
