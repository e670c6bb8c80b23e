"""The numbers of a projectile in projectile.xml."""

from __future__ import annotations

from typing import Any

from plumbob.analytic.systems.projectile import Projectile


def fill(spec: Any, projectile: Projectile) -> None:
    """Write the numbers of a projectile into an MjSpec of projectile.xml."""
    spec.option.gravity = [0.0, 0.0, -projectile.gravity]
    spec.key("start").qvel = projectile.motion.system.rate
