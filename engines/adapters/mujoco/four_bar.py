"""The four-bar linkage in MuJoCo's terms: a chain of rods whose end is tied to an axis softly."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from plumbob.engines.adapters.mujoco import n_pendulum
from plumbob.engines.adapters.mujoco.slider_crank import LOOP
from plumbob.engines.adapters.mujoco.slider_crank import scheme as scheme
from plumbob.engines.adapters.mujoco.translation import Translation, filled, solved_loop
from plumbob.engines.method import Method, ModelError
from plumbob.models.four_bar.model import fill


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a FourBar."""
    return n_pendulum.of_chain(filled(mjcf, fill, problem), problem.opened)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The arithmetic of the solver, whose Hessian has a condition that grows next to the change
    point; the soft constraint itself is part of the step."""
    worse = math.sin(problem.transmission_angle) ** -2
    angle = {why: worse * e for why, e in solved_loop(problem.motion, LOOP, duration).items()}
    place = {why: 2 * problem.crank * e for why, e in angle.items()}
    return {"angle": angle, "coupler_x": place, "coupler_y": place}
