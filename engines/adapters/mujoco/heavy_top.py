"""Lagrange's top in MuJoCo's terms: three hinges in one body, whose angles are Euler's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.translation import Named, Translation, read
from plumbob.engines.adapters.stepping import no_error
from plumbob.engines.method import Method

model_error = no_error  # the model is the top itself


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a HeavyTop."""
    spec, system = whole(mjcf, problem), problem.motion.system
    for shown in tuple(spec.geoms):  # without effect, and a step costs less without them
        spec.delete(shown)

    def observe(qpos: Array, qvel: Array) -> tuple[Named, Named]:
        return system.observed(np.concatenate([qpos, qvel], axis=1).T), {}

    return Translation(spec, np.array(system.position), np.array(system.rate), observe)


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
