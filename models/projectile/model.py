"""The relation of a projectile to projectile.xml."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.projectile import Projectile
from plumbob.models.model_file import ModelFile


def fill(spec: Any, projectile: Projectile) -> None:
    """Writes the numbers of a projectile into an MjSpec of projectile.xml."""
    spec.option.gravity = [0.0, 0.0, -projectile.gravity]
    spec.key("start").qvel = projectile.motion.system.rate


def observe(projectile: Projectile, qpos: Array, qvel: Array) -> Signals:
    """Returns the place, the angle, and their rates."""
    return projectile.motion.system.observed(np.concatenate([qpos, qvel], axis=1).T)


MODEL = ModelFile(fill, observe)
