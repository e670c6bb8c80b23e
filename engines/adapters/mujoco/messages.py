"""MuJoCo's own log, taken from the console and from its file into a list."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco


@contextmanager
def collected() -> Iterator[list[str]]:
    """Collect what the engine logs while the block runs; nothing is printed or written to disk."""
    messages: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(messages.append)
    try:
        yield messages
    finally:
        mujoco.set_mju_user_warning(before)
