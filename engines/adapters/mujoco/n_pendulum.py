"""A chain of rods in MuJoCo's terms: the model's file with as many rods as a problem has."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.engines.adapters.mujoco.translation import Translation, filled, of_system
from plumbob.engines.method import Method
from plumbob.models.n_pendulum.model import fill


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate an NPendulum."""
    return of_chain(filled(mjcf, fill, problem), problem.motion.system)


def of_chain(spec: mujoco.MjSpec, system: SmoothSystem) -> Translation:
    """The translation of a chain's model; a hinge's angle is that from the rod above."""
    return of_system(spec, system, lambda joints: np.cumsum(joints, axis=1))
