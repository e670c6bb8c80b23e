"""A projectile in MuJoCo's terms: two slides and a hinge."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco

from plumbob.engines.adapters.mujoco.translation import Translation, of_system, read
from plumbob.engines.method import Method


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a Projectile."""
    return of_system(whole(mjcf, problem), problem.motion.system)


def whole(mjcf: Path, problem: Any) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, visual parts included."""
    spec = read(mjcf, problem.gravity)
    spec.key("start").qvel = problem.motion.system.rate
    return spec
