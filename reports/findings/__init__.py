"""What the page says of a system beside what it says of every scene: a module a system, found by
the system's name; a system without one has the rest."""

from __future__ import annotations

import importlib

from plumbob.engines.study.extra_runs import Request, StudyPlan
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


def requests(plan: StudyPlan) -> tuple[Request, ...]:
    """The runs that the findings of a plan's systems look up, each once, in a fixed order; those of
    a table that every scene has come beside them."""
    sections = (section(name) for name in dict.fromkeys(scene.system for scene in plan.scenes))
    wanted = (request for own in sections if own for request in own.requests(plan))
    return tuple(dict.fromkeys(wanted))
