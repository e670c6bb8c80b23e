"""The page's section on the capsule on a line: the source's figure and formulas, and contacts."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.reports.findings.capsule_line import (
    any_line,
    errors,
    hard,
    heights,
    hops,
    isotropy,
    loads,
    misprints,
    momentum,
    saving,
    sawtooth,
    source_figure,
)
from plumbob.reports.view.content import Figure, Finding, Section


def findings(study: Study) -> Sequence[Finding]:
    """Everything that holding the source and the engines against each other showed."""
    found = (
        misprints.finding(),
        any_line.finding(),
        errors.finding(study),
        sawtooth.finding(study),
        hops.finding(),
        isotropy.finding(study),
        loads.finding(),
        heights.finding(),
        momentum.finding(),
        saving.finding(study),
    )
    return tuple(one for one in found if one is not None)


def figures(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    """The source's Fig. 2, exact and as two engines have it."""
    return source_figure.galleries()


SECTION = Section(findings, figures, hard.hard)
