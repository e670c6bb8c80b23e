"""The page's section on engines side by side, which belongs to no system: what their readers take
from a model file."""

from __future__ import annotations

from plumbob.reports.findings.engines import readers
from plumbob.reports.view.content import Section

SECTION = Section((readers.finding,), requests=readers.requests)
