"""The section on the capsule's turn: formulas and exact motion."""

from __future__ import annotations

from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.capsule_turn.course import COURSE
from plumbob.reports.analyses.capsule_turn.exact_motion import SECOND_ORDER, TOUCH
from plumbob.reports.analyses.capsule_turn.left_over import LEFT_OVER
from plumbob.reports.analyses.capsule_turn.source_text import SOURCE

FINDINGS = (SECOND_ORDER, COURSE, LEFT_OVER, TOUCH, SOURCE)
SECTION = Section(FINDINGS)
