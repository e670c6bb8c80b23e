"""The page's section on the capsule's turn: the formula, the engines, the modes of the motion."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.reports.findings.capsule_turn import angle, formulas, hard, leak, sag, touching
from plumbob.reports.view.content import Figure, Finding, Section


def findings(study: Study) -> Sequence[Finding]:
    """What the formulas, the exact motion and the engines show against each other."""
    found = (
        formulas.finding(),
        angle.finding(study),
        leak.finding(study),
        sag.finding(study),
        touching.finding(),
    )
    return tuple(one for one in found if one is not None)


def _figures(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    return ()


SECTION = Section(findings, _figures, hard.hard)
