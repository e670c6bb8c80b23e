"""The error of MuJoCo's model of Lagrange's top: rounding of its axes."""

from __future__ import annotations

import math
from typing import Any

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.engines.method import Method, ModelError

AXES = 8.0  # calibrated: rotation by rounded axes per angle of spin, in units in the last place


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The bound on the precession angle: by rounding of the axes, a fraction of the spin turns the
    top about the vertical."""
    turned = AXES * ULP * abs(problem.spin_rate) * duration / math.sin(problem.tilt)
    return {"precession": {"rounded axes": turned}}
