"""The relation of a heavy top to heavy_top.xml."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.heavy_top import HeavyTop
from plumbob.models.model_file import ModelFile


def fill(spec: Any, top: HeavyTop) -> None:
    """Writes the numbers of a top into an MjSpec of heavy_top.xml."""
    across = top.inertia_across
    body = spec.body("top")
    start = spec.key("start")
    spec.option.gravity = [0.0, 0.0, -top.gravity]
    body.mass = top.mass
    body.ipos = [0.0, 0.0, top.length]
    body.inertia = [across, across, top.inertia_axis]
    start.qpos = top.motion.system.position
    start.qvel = top.motion.system.rate


def observe(top: HeavyTop, qpos: Array, qvel: Array) -> Signals:
    """Returns Euler's angles, their rates, and the observables that follow from them."""
    return top.motion.system.observed(np.concatenate([qpos, qvel], axis=1).T)


MODEL = ModelFile(fill, observe)
