"""Lagrange's top in MuJoCo's terms: three hinges in one body, whose angles are Euler's."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.engines.adapters.mujoco.translation import Translation, of_system, read
from plumbob.engines.method import Method, ModelError

# calibrated, units in the last place: how far rounded axes turn what spins, on and on
AXES = 8.0


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a HeavyTop."""
    return of_system(whole(mjcf, problem), problem.motion.system)


def model_error(problem: Any, duration: float, method: Method, step: float) -> ModelError:
    """The model is the top itself; a part of the spin, by rounding, turns about the vertical."""
    turned = AXES * ULP * abs(problem.spin_rate) * duration / math.sin(problem.tilt)
    return {"precession": {"rounded axes": turned}}


def whole(mjcf: Path, problem: Any) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, visual parts included."""
    spec = read(mjcf, problem.gravity)
    top = spec.body("top")
    across = problem.inertia_across
    top.mass = problem.mass
    top.ipos = [0.0, 0.0, problem.length]
    top.inertia = [across, across, problem.inertia_axis]
    start = spec.key("start")
    system = problem.motion.system
    start.qpos = system.position
    start.qvel = system.rate
    return spec
