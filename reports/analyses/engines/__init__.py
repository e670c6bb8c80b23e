"""The page's section on engines side by side, which belongs to no system: the largest steps that
hold, derivatives, for how long methods are right, and what readers take from a model file."""

from __future__ import annotations

from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.engines.gradients import GRADIENTS
from plumbob.reports.analyses.engines.largest_steps import LARGEST_STEPS
from plumbob.reports.analyses.engines.long_runs import LONG_RUNS
from plumbob.reports.analyses.engines.readers import READERS
from plumbob.reports.analyses.engines.through_contact import THROUGH_CONTACT

SECTION = Section((LARGEST_STEPS, THROUGH_CONTACT, GRADIENTS, LONG_RUNS, READERS))
