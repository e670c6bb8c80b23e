"""What MuJoCo adds to Lagrange's top: rounding of its axes."""

from __future__ import annotations

import math
from typing import Any

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.engines.method import Method, ModelError

# calibrated, units in the last place: how far rounded axes turn what spins, on and on
AXES = 8.0


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The model is the top itself; a part of the spin, by rounding, turns about the vertical."""
    turned = AXES * ULP * abs(problem.spin_rate) * duration / math.sin(problem.tilt)
    return {"precession": {"rounded axes": turned}}
