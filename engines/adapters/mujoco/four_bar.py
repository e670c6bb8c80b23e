"""The four-bar linkage in MuJoCo: its end is tied to an axis softly."""

from __future__ import annotations

import math
from typing import Any

from plumbob.engines.adapters.mujoco.slider_crank import LOOP
from plumbob.engines.adapters.mujoco.slider_crank import scheme as scheme
from plumbob.engines.adapters.mujoco.translation import solved_loop
from plumbob.engines.method import Method, ModelError


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The arithmetic of the solver, whose Hessian has a condition that grows next to the change
    point; the soft constraint itself is part of the step."""
    worse = math.sin(problem.transmission_angle) ** -2
    angle = {why: worse * e for why, e in solved_loop(problem.motion, LOOP, duration).items()}
    place = {why: 2 * problem.crank * e for why, e in angle.items()}
    return {"angle": angle, "coupler_x": place, "coupler_y": place}
