"""A projectile in MuJoCo's terms: two slides and a hinge."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from plumbob.engines.adapters.mujoco.translation import Translation, filled, of_system
from plumbob.engines.method import Method
from plumbob.models.projectile.model import fill


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """Translate a Projectile."""
    return of_system(filled(mjcf, fill, problem), problem.motion.system)
