"""An analysis: the runs that it needs, the numbers that it computes, their checks, a template."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

from plumbob.engines.registry import engine_of, installed
from plumbob.engines.study.extra_runs import Requests, StudyPlan
from plumbob.engines.study.request import Request, RunRequest
from plumbob.engines.study.results import Analysed, Study
from plumbob.reports.judge.study_verdicts import Judgements, unexpected_pairs
from plumbob.reports.records.claim import Claim
from plumbob.reports.records.exact_numbers import exact_numbers_of
from plumbob.reports.records.plain_data import FOR_TEMPLATES, plain

Record = SimpleNamespace
"""Numbers, texts, arrays and further records, by the names that a template reads."""
FindingNumbers = Any
"""A record; None if the study lacks the scenes or runs of the analysis."""


@dataclass(frozen=True)
class Analysis:
    """An analysis of a study, with the template that holds all its words, tables and figures."""

    template: str  # name in reports/templates, as "cone_pendulum/equilibria"
    numbers: Callable[[Study], FindingNumbers] = lambda study: Record()
    requests: Requests = lambda plan: ()  # runs needed in addition to the study's own
    # checks that the numbers support the text of the template
    claims: Callable[[FindingNumbers], Sequence[Claim]] = lambda numbers: ()
    exact: Callable[[], Record] | None = None
    """Computes the numbers that no measurement enters. A study does not compute them: they are
    shipped in reports/exact_numbers, and `python -m plumbob.tests.validation.exact_numbers` writes
    them."""

    def needs_pairs_of(self, plan: StudyPlan) -> bool:
        """Returns whether all runs that the analysis needs are of scenes and methods of the plan. A
        method whose engine is not installed runs nothing, and does not count."""
        runs = [request for request in self.requests(plan) if isinstance(request, RunRequest)]
        others = (run for run in runs if not plan.has(run.scene, run.method))
        return not any(installed(engine_of(plan.method(run.method))) for run in others)


@dataclass(frozen=True)
class Section:
    """The analyses of one system, by their places on its pages."""

    findings: tuple[Analysis, ...]
    galleries: tuple[Analysis, ...] = ()  # each one is a heading with figures

    def requests(self, plan: StudyPlan, pairs_alone: bool = False) -> Sequence[Request[Any]]:
        """Returns the runs that the analyses need in addition to the study's own. If `pairs_alone`,
        analyses that need other scenes or methods than the plan's are left out."""
        requested = list[Request[Any]]()
        for analysis in (*self.findings, *self.galleries):
            if not pairs_alone or analysis.needs_pairs_of(plan):
                requested += analysis.requests(plan)
        return tuple(requested)


def analyse_section(
    study: Study, section: Section, system: str, judged: Judgements
) -> tuple[Analysed, ...]:
    """Returns the numbers of all analyses of the section of a `system`, or of "engines". Analyses
    whose runs were not asked for are left out.

    If an analysis fails and the study has unexpected verdicts, the analysis is left out, with these
    verdicts as its failed claims. If it fails without any unexpected verdict, its error is raised:
    it is a defect of plumbob."""
    plan = StudyPlan(study.profile, study.scenes, study.methods)
    results = list[Analysed]()
    for analysis in (*section.findings, *section.galleries):
        if not study.extras.keys() >= set(analysis.requests(plan)):
            continue
        place = "finding" if analysis in section.findings else "gallery"
        left_out = Analysed(analysis.template, place, system, "", None)
        try:
            numbers = analysis.numbers(study)
            if numbers is None:
                continue
            checks = analysis.claims(with_exact_numbers(analysis, numbers))
            claims = tuple((claim.text, bool(claim.holds)) for claim in checks)
            results.append(
                replace(left_out, numbers=plain(numbers, FOR_TEMPLATES), claims=claims)
            )
        except Exception:
            pairs = unexpected_pairs(study, judged)
            if not pairs:
                raise
            results.append(replace(left_out, claims=tuple((pair, False) for pair in pairs)))
    return tuple(results)


def with_exact_numbers(analysis: Analysis, numbers: FindingNumbers) -> FindingNumbers:
    """Returns the numbers of an analysis of a study together with its shipped numbers, if it has
    any."""
    shipped = exact_numbers_of(analysis.template)
    return Record(**vars(numbers), **shipped.numbers) if shipped else numbers
