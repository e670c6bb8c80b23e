"""The relation of a servo to servo.xml."""

from __future__ import annotations

from typing import Any

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.servo import Servo
from plumbob.models.largest import largest_pendulum_rates
from plumbob.models.model_file import ModelFile
from plumbob.models.simple_pendulum.model import first_coefficient, hinge_angle


def fill(spec: Any, servo: Servo) -> None:
    """Writes the numbers of a servo into an MjSpec of servo.xml."""
    joint = spec.joint("theta")
    motor = spec.actuator("motor")
    start = spec.key("start")
    spec.body("link").inertia = [servo.inertia] * 3
    joint.armature = servo.armature
    joint.damping = first_coefficient(joint.damping, servo.damping)
    motor.gear[0] = servo.gear
    motor.gainprm[0] = servo.kp
    motor.biasprm[1:3] = [-servo.kp, -servo.kv]
    motor.forcerange = [-servo.force_limit, servo.force_limit]
    # If the exact motion never saturates, the motor has no limit: a run whose step is too large
    # then diverges visibly.
    motor.forcelimited = int(servo.saturates)
    start.qpos = [servo.theta]
    start.qvel = [servo.theta_dot]


def observe(servo: Servo, qpos: Array, qvel: Array) -> Signals:
    """Returns the angle from the target, and its rate."""
    return hinge_angle(qpos, qvel)


MODEL = ModelFile(fill, observe, largest=lambda servo: largest_pendulum_rates(servo.started))
