"""The page's section on engines side by side, which belongs to no system: what their readers take
from a model file."""

from __future__ import annotations

from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.engines.readers import READERS

SECTION = Section((READERS,))
