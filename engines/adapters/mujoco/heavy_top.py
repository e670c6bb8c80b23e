"""Lagrange's top in MuJoCo's terms: three hinges in one body, whose angles are Euler's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco

from plumbob.engines.adapters.mujoco.translation import Translation, of_system, read
from plumbob.engines.adapters.stepping import no_error
from plumbob.engines.method import Method

model_error = no_error  # the model is the top itself


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a HeavyTop."""
    return of_system(whole(mjcf, problem), problem.motion.system)


def whole(mjcf: Path, problem: Any) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, visual parts included."""
    spec = read(mjcf)
    spec.option.gravity = [0.0, 0.0, -problem.gravity]
    top, across = spec.body("top"), problem.inertia_across
    top.mass, top.ipos = problem.mass, [0.0, 0.0, problem.length]
    top.inertia = [across, across, problem.inertia_axis]
    start, system = spec.key("start"), problem.motion.system
    start.qpos, start.qvel = system.position, system.rate
    return spec
