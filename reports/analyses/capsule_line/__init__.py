"""The section on the capsule on a line: the source's formulas, errors, contacts and models."""

from __future__ import annotations

from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.capsule_line.contacts import CHATTER, LOAD_ERRORS
from plumbob.reports.analyses.capsule_line.displacement import ERRORS
from plumbob.reports.analyses.capsule_line.drive import DRIVE
from plumbob.reports.analyses.capsule_line.experiment import EXPERIMENT
from plumbob.reports.analyses.capsule_line.fidelity import HEIGHTS, MOMENTUM
from plumbob.reports.analyses.capsule_line.headings import ISOTROPY
from plumbob.reports.analyses.capsule_line.identified import IDENTIFIED
from plumbob.reports.analyses.capsule_line.source import ANY_LINE, FIGURE_2, MISPRINTS
from plumbob.reports.analyses.capsule_line.source_text import SOURCE
from plumbob.reports.analyses.capsule_line.tipping import TIPPING

FINDINGS = (
    MISPRINTS,
    ANY_LINE,
    SOURCE,
    ERRORS,
    CHATTER,
    ISOTROPY,
    IDENTIFIED,
    LOAD_ERRORS,
    DRIVE,
    TIPPING,
    HEIGHTS,
    MOMENTUM,
    EXPERIMENT,
)
SECTION = Section(FINDINGS, (FIGURE_2,))
