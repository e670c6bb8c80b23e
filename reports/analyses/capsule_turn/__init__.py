"""The page's section on the capsule's turn: formula, exact motion, engines, modes of motion."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.extra_runs import Request, StudyPlan
from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.capsule_turn import (
    body_angle,
    course,
    exact_motion,
    left_over,
    modes,
    source_text,
    turns,
)


def requests(plan: StudyPlan) -> Sequence[Request]:
    """The runs that the findings look up."""
    return (*turns.requests(plan), *course.requests(plan))


FINDINGS = (
    exact_motion.second_order,
    course.finding,
    left_over.finding,
    body_angle.angle,
    body_angle.leak,
    body_angle.deflection,
    exact_motion.touching,
    source_text.finding,
)
SECTION = Section(FINDINGS, hard=(modes.hard,), more=requests)
