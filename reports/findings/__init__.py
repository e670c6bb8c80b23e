"""What the page says of a system beside what it says of every scene: a module a system, found by
the system's name; a system without one has the rest."""

from __future__ import annotations

import importlib

from plumbob.reports.view.content import Section


def section(system: str) -> Section | None:
    """The section of a system, SECTION of `plumbob.reports.findings.<system>`; None without one."""
    name = f"{__name__}.{system.replace('-', '_')}"
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        return None
    found: Section = module.SECTION
    return found
