"""Descriptions of the systems for the reader of a page: parts, symbols, equation, source."""

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
            description: Description = module.DESCRIPTIONS[system]
            return description
    return None
