"""How an adapter finds its builder of a system: a module named after the system's family."""

from __future__ import annotations

import importlib
from types import ModuleType

from plumbob.engines.method import Unsupported
from plumbob.models.scene import System


def find_builder(engine: str, system: System) -> ModuleType:
    """The module `adapters/<engine>/<family>.py` that builds `system`; raises Unsupported when
    the engine has none."""
    name = f"{__package__}.{engine}.{system.family}"
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        raise Unsupported(f"{engine} has no builder for {system.name}") from None
