"""The relation of a servo to servo.xml."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.servo import Servo
from plumbob.models.largest import largest_pendulum_rates
from plumbob.models.model_file import Feedback, ModelFile
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
    if servo.loop is None:
        motor.gainprm[0] = servo.kp
        motor.biasprm[1:3] = [-servo.kp, -servo.kv]
    else:  # the force is the control
        motor.gainprm[0] = 1.0
        motor.biasprm[1:3] = [0.0, 0.0]
    motor.forcerange = [-servo.force_limit, servo.force_limit]
    # If the exact motion never saturates, the motor has no limit: a run whose step is too large
    # then diverges visibly.
    motor.forcelimited = int(servo.saturates)
    start.qpos = [servo.theta]
    start.qvel = [servo.theta_dot]


def observe(servo: Servo, qpos: Array, qvel: Array) -> Signals:
    """Returns the angle from the target, and its rate."""
    return hinge_angle(qpos, qvel)


def controls(servo: Servo) -> Feedback | None:
    """Returns the digital controller of the motor; None if the motor is continuous."""
    if servo.loop is None:
        return None

    def force(time: float, qpos: Array, qvel: Array) -> Array:
        """Returns the force before the gear [N m] in a state."""
        return np.asarray(-servo.gear * (servo.kp * qpos + servo.kv * qvel))

    return Feedback(servo.loop.times, force, 1)


def largest(servo: Servo) -> Mapping[str, float]:
    """Returns the rate that only a diverged run exceeds; none for a loop, whose motion may grow."""
    return {} if servo.loop else largest_pendulum_rates(servo.started)


MODEL = ModelFile(fill, observe, controls=controls, largest=largest)
