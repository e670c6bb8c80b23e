"""A simulation of PyBullet, apart from all others."""

from __future__ import annotations

from typing import Any

from plumbob.models.entry_points import captured

TOUCHES = 0.02  # [m]: Bullet's default distance of contacts, one for all worlds of a process


def new_client() -> Any:
    """A client of a simulation of its own, which ends with the last reference to it."""
    with captured():  # what its C code prints
        import pybullet
        from pybullet_utils.bullet_client import BulletClient

        client = BulletClient(connection_mode=pybullet.DIRECT)
    client.setPhysicsEngineParameter(contactBreakingThreshold=TOUCHES)
    return client
