"""The servo in MuJoCo's terms: a hinge with a position actuator, whose control stays 0."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco

from plumbob.engines.adapters.mujoco.simple_pendulum import of_hinge
from plumbob.engines.adapters.mujoco.translation import Translation, at_start, bare, filled
from plumbob.engines.method import Method, ModelError
from plumbob.models.servo.model import fill

DROPPED = math.sqrt(mujoco.mjMINVAL)  # [N m]: `discrete` leaves out forces of a smaller norm


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a Servo; the hinge's angle [rad] is measured from the target."""
    spec = bare(filled(mjcf, fill, problem))
    # If the exact motion never saturates, the motor has no limit: a run whose step is too large
    # then diverges visibly.
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
