"""Lagrange's top in MuJoCo's terms: three hinges in one body, whose angles are Euler's."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.engines.adapters.mujoco.translation import Translation, filled, of_system
from plumbob.engines.method import Method, ModelError
from plumbob.models.heavy_top.model import fill

# calibrated, units in the last place: how far rounded axes turn what spins, on and on
AXES = 8.0


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a HeavyTop."""
    return of_system(filled(mjcf, fill, problem), problem.motion.system)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The model is the top itself; a part of the spin, by rounding, turns about the vertical."""
    turned = AXES * ULP * abs(problem.spin_rate) * duration / math.sin(problem.tilt)
    return {"precession": {"rounded axes": turned}}
