"""Sections of the page for one system each, in a module found by the system's name; a system
without one has only what every scene has. The module `engines` holds findings for all systems."""

from __future__ import annotations

import importlib

from plumbob.engines.study.extra_runs import Request, StudyPlan
from plumbob.reports.view.content import Section
from plumbob.reports.view.replay.runs import requests as replay_requests
from plumbob.reports.view.site.views import OF_ENGINES
from plumbob.reports.view.trimming import requests as trimming_requests


def section(system: str) -> Section | None:
    """The section of a system, SECTION of `plumbob.reports.findings.<system>`; None without one."""
    name = f"{__name__}.{system.replace('-', '_')}"
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        return None
    section_of: Section = module.SECTION
    return section_of


def requests(plan: StudyPlan) -> tuple[Request, ...]:
    """All runs that a page of this plan needs beside the study's own, each once: those of the
    systems' findings and of those on engines, then those of the replays and of the table of trimmed
    models."""
    named = dict.fromkeys((*(scene.system for scene in plan.scenes), OF_ENGINES))
    extra = [request for name in named if (of := section(name)) for request in of.requests(plan)]
    return tuple(dict.fromkeys((*extra, *replay_requests(plan), *trimming_requests(plan))))
