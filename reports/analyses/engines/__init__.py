"""The section on engines side by side: errors and costs, largest stable steps, derivatives, long
runs, the fields that engines read from a model file, and policies in the loop."""

from __future__ import annotations

from plumbob.reports.analyses.analysis import Analysis, Section
from plumbob.reports.analyses.engines.errors_and_costs import ERRORS_AND_COSTS
from plumbob.reports.analyses.engines.gradients import GRADIENTS
from plumbob.reports.analyses.engines.largest_steps import LARGEST_STEPS
from plumbob.reports.analyses.engines.long_runs import LONG_RUNS
from plumbob.reports.analyses.engines.readers import READERS
from plumbob.reports.analyses.engines.through_contact import THROUGH_CONTACT

# Their numbers are not of the study: `python -m plumbob.tests.validation.loop_findings` computes
# those that are shipped in reports/exact_numbers.
POLICIES = (
    Analysis("engines/cheetah_rhythm"),
    Analysis("engines/trained_policies"),
    Analysis("engines/cart_pole_loop"),
)
SECTION = Section(
    (
        ERRORS_AND_COSTS,
        LARGEST_STEPS,
        THROUGH_CONTACT,
        GRADIENTS,
        LONG_RUNS,
        READERS,
        *POLICIES,
    )
)
