"""The four-bar linkage in MuJoCo: a soft constraint ties its end to an axis."""

from __future__ import annotations

import math
from typing import Any

from plumbob.engines.adapters.mujoco.slider_crank import LOOP
from plumbob.engines.adapters.mujoco.slider_crank import scheme as scheme
from plumbob.engines.adapters.mujoco.translation import solved_loop
from plumbob.engines.method import Method, ModelError


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """Bounds on the rounding of the solver, whose Hessian is worse conditioned next to the change
    point. The softness of the constraint is part of the scheme."""
    condition = math.sin(problem.transmission_angle) ** -2
    rounding = solved_loop(problem.motion, LOOP, duration)
    angle = {reason: condition * bound for reason, bound in rounding.items()}
    place = {reason: 2 * problem.crank * bound for reason, bound in angle.items()}
    return {"angle": angle, "coupler_x": place, "coupler_y": place}
