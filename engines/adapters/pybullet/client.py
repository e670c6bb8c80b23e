"""A simulation of PyBullet, apart from all others."""

from __future__ import annotations

from typing import Any

from plumbob.models.entry_points import captured


def new_client() -> Any:
    """A client of a simulation of its own, which ends with the last reference to it."""
    with captured():  # what its C code prints
        import pybullet
        from pybullet_utils.bullet_client import BulletClient

        return BulletClient(connection_mode=pybullet.DIRECT)
