"""Errors of Euler steps on a ball that slides until it rolls.

In a step h friction reduces the speed by f g h, and the slip by 7/2 of that. If the slip would
change its sign, the step ends the slip instead. Speeds at the ends of steps are therefore exact,
except in that one step. The position is not exact: it is the sum of the speeds.
"""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.smooth_motion.scheme_steps import whole_steps
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.rolling_ball import RollingBall
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors, signal_differences


def rolling_errors(ball: RollingBall) -> StepErrors:
    """Returns the errors of steps on a ball.

    The errors are empty for schemes that are not stepped here. They are empty for rolling friction,
    too, for which engines have other laws.
    """

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        """Returns the errors of place, speed and spin at `times` [s], with their rounding."""
        if scheme.integrator != EULER or ball.rolling_friction:
            return {}
        marks = whole_steps(times, step)
        slip = ball.speed - ball.radius * ball.spin  # [m/s] at the start
        steps = np.arange(marks[-1] + 1)
        slip_loss = np.minimum(3.5 * ball.friction * ball.gravity * step * steps, abs(slip))
        slip_loss *= np.sign(slip)
        speed = ball.speed - slip_loss * 2.0 / 7.0
        spin = ball.spin + slip_loss * 5.0 / 7.0 / ball.radius
        step_speeds = speed[:-1] if scheme.position_first else speed[1:]
        x = np.concatenate([[0.0], np.cumsum(step * step_speeds)])
        stepped = {"x": x[marks], "speed": speed[marks], "spin": spin[marks]}
        doubt = ball.scale * ULP * np.ones(len(times))
        return SteppedErrors(
            signal_differences(stepped, ball.observe(times)),
            {"x": doubt * (step + times), "speed": doubt, "spin": doubt / ball.radius},
        )

    return StepErrors(error)
