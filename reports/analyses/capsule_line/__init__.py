"""The section on the capsule on a line: the source's formulas, errors, contacts and models."""

from __future__ import annotations

from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.capsule_line.contacts import CHATTER_ANALYSIS, LOAD_ERRORS
from plumbob.reports.analyses.capsule_line.displacement import DISPLACEMENT_ERRORS
from plumbob.reports.analyses.capsule_line.drive import DRIVE
from plumbob.reports.analyses.capsule_line.experiment import EXPERIMENT
from plumbob.reports.analyses.capsule_line.fidelity import HEIGHTS, MOMENTUM_FINDING
from plumbob.reports.analyses.capsule_line.headings import ISOTROPY
from plumbob.reports.analyses.capsule_line.identified import IDENTIFIED
from plumbob.reports.analyses.capsule_line.source import ANY_LINE, FIGURE_2, MISPRINTS
from plumbob.reports.analyses.capsule_line.source_text import LINE_SOURCE_TEXT
from plumbob.reports.analyses.capsule_line.tipping import TIPPING

CAPSULE_LINE_FINDINGS = (
    MISPRINTS,
    ANY_LINE,
    LINE_SOURCE_TEXT,
    DISPLACEMENT_ERRORS,
    CHATTER_ANALYSIS,
    ISOTROPY,
    IDENTIFIED,
    LOAD_ERRORS,
    DRIVE,
    TIPPING,
    HEIGHTS,
    MOMENTUM_FINDING,
    EXPERIMENT,
)
SECTION = Section(CAPSULE_LINE_FINDINGS, (FIGURE_2,))
