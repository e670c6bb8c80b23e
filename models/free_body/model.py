"""The numbers of a free body in free_body.xml."""

from __future__ import annotations

from typing import Any

from plumbob.analytic.systems.free_body.problem import FreeBody


def fill(spec: Any, body: FreeBody) -> None:
    """Write the numbers of a free body into an MjSpec of free_body.xml."""
    spec.body("body").inertia = list(body.inertia)
    spec.key("start").qvel = [0.0, 0.0, 0.0, *body.angular_velocity]
