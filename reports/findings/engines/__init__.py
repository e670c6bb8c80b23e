"""The page's section on engines side by side, which belongs to no system: what their readers take
from a model file."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.reports.findings.engines import readers
from plumbob.reports.view.content import Finding, Section


def findings(study: Study) -> Sequence[Finding]:
    """What holds for engines, whatever the system."""
    return [one for one in (readers.finding(study),) if one is not None]


SECTION = Section(findings, requests=readers.requests)
