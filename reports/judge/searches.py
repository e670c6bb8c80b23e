"""Judged searches of a study, apart from its convergence studies: largest steps, and
derivatives."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from plumbob.engines.study.results import Study
from plumbob.reports.judge.gradients import JudgedGradient, study_gradients
from plumbob.reports.judge.stability import JudgedLimit, study_limits

JudgedSearch = JudgedLimit | JudgedGradient


def judged_searches(study: Study) -> Sequence[JudgedSearch]:
    """Returns all judged searches that a study holds."""
    return (*study_limits(study), *study_gradients(study))


def unexpected_searches(judged: Iterable[JudgedSearch]) -> Sequence[JudgedSearch]:
    """Returns the judged searches whose verdict is not as expected."""
    return [search for search in judged if search.surprise]
