"""The numbers of a heavy top in heavy_top.xml."""

from __future__ import annotations

from typing import Any

from plumbob.analytic.systems.heavy_top import HeavyTop


def fill(spec: Any, top: HeavyTop) -> None:
    """Write the numbers of a top into an MjSpec of heavy_top.xml."""
    across = top.inertia_across
    body = spec.body("top")
    start = spec.key("start")
    spec.option.gravity = [0.0, 0.0, -top.gravity]
    body.mass = top.mass
    body.ipos = [0.0, 0.0, top.length]
    body.inertia = [across, across, top.inertia_axis]
    start.qpos = top.motion.system.position
    start.qvel = top.motion.system.rate
