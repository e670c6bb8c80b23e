"""The error of MuJoCo's integrator `discrete` on a servo: it drops small forces."""

from __future__ import annotations

import math
from typing import Any

import mujoco

from plumbob.engines.method import Method, ModelError

DROPPED = math.sqrt(mujoco.mjMINVAL)  # [N m] `discrete` leaves out forces of a smaller norm


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds on the angle and the rate from forces that `discrete` leaves out, by the integral of
    the response to such a force. Empty for other integrators."""
    if method.settings["integrator"] != "discrete":
        return {}
    linear = problem.started
    natural = math.sqrt(linear.gravity)
    damping = linear.damping_rate
    lasting = min(duration, 2.0 / damping) if damping else duration
    angle = DROPPED / linear.mass * (1.0 / natural + lasting) / natural
    reason = "forces below a threshold"
    return {"theta": {reason: angle}, "theta_dot": {reason: angle * natural}}
