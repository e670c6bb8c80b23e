"""Makes separate simulations in PyBullet."""

from __future__ import annotations

from typing import Any

from plumbob.models.entry_points import captured

# [m] Bullet's default distance at which contacts act, one number for all clients of a process
CONTACT_DISTANCE = 0.02
BASE = -1  # number of a multibody's base among its links


def error_of_pybullet() -> Any:
    """The exception that PyBullet raises, a class."""
    with captured():  # PyBullet's C code prints lines
        import pybullet
    return pybullet.error


def new_client() -> Any:
    """A client with a separate simulation, which ends with the last reference to the client."""
    with captured():  # PyBullet's C code prints lines
        import pybullet
        from pybullet_utils.bullet_client import BulletClient

        client = BulletClient(connection_mode=pybullet.DIRECT)
    client.setPhysicsEngineParameter(contactBreakingThreshold=CONTACT_DISTANCE)
    return client
