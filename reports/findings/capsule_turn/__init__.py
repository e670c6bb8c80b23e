"""The page's section on the capsule's turn: formula, exact motion, engines, modes of motion."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.extra_runs import Request, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.findings.capsule_turn import (
    body_angle,
    course,
    exact_motion,
    left_over,
    modes,
    source_text,
    turns,
)
from plumbob.reports.view.content import Finding, Section


def requests(plan: StudyPlan) -> Sequence[Request]:
    """The runs that the findings look up."""
    return (*turns.requests(plan), *course.requests(plan))


def findings(study: Study) -> Sequence[Finding]:
    """What comparing the formulas, the exact motion and the engines showed."""
    found = (
        exact_motion.second_order(),
        course.finding(study),
        left_over.finding(study),
        body_angle.angle(study),
        body_angle.leak(study),
        body_angle.deflection(study),
        exact_motion.touching(),
        source_text.finding(),
    )
    return tuple(one for one in found if one is not None)


SECTION = Section(findings, hard=modes.hard, requests=requests)
