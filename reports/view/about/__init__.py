"""What a reader must know of a system to follow its page: its parts, symbols, equation, source."""

from __future__ import annotations

import importlib

from plumbob.reports.view.about.description import Description, Label

__all__ = ["Description", "Label", "described"]
MODULES = ("cone", "capsule", "pendulums")


def described(system: str) -> Description | None:
    """The description of a system by its name; None where there is none."""
    for name in MODULES:
        module = importlib.import_module(f"{__name__}.{name}")
        if system in module.DESCRIPTIONS:
            found: Description = module.DESCRIPTIONS[system]
            return found
    return None
