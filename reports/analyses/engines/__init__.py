"""The section on engines side by side: errors and costs, largest stable steps, derivatives, long
runs, and the fields that engines read from a model file."""

from __future__ import annotations

from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.engines.errors_and_costs import ERRORS_AND_COSTS
from plumbob.reports.analyses.engines.gradients import GRADIENTS
from plumbob.reports.analyses.engines.largest_steps import LARGEST_STEPS
from plumbob.reports.analyses.engines.long_runs import LONG_RUNS
from plumbob.reports.analyses.engines.readers import READERS
from plumbob.reports.analyses.engines.through_contact import THROUGH_CONTACT

SECTION = Section(
    (ERRORS_AND_COSTS, LARGEST_STEPS, THROUGH_CONTACT, GRADIENTS, LONG_RUNS, READERS)
)
