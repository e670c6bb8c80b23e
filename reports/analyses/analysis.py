"""An analysis: runs that it needs, numbers of a study, checks of them, and a template."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from plumbob.engines.study.extra_runs import Requests, StudyPlan
from plumbob.engines.study.request import Request
from plumbob.engines.study.results import Analysed, Study
from plumbob.reports.judge.study_verdicts import Judgements, unexpected_pairs
from plumbob.reports.view.content import Claim

Record = SimpleNamespace
"""Numbers, texts, arrays, and records, sequences and mappings of them, by the names that a template
reads."""
Numbers = Any
"""A record; None where a study lacks what the analysis is about."""


@dataclass(frozen=True)
class Analysis:
    """An analysis of a study, with the template that holds all its words, tables and figures."""

    template: str  # "cone_pendulum/equilibria" of reports/templates
    numbers: Callable[[Study], Numbers]
    requests: Requests = lambda plan: ()  # runs beside the study's own
    claims: Callable[[Numbers], Sequence[Claim]] = lambda numbers: ()  # that its words rest on


@dataclass(frozen=True)
class Section:
    """The analyses of one system, by their places on its pages."""

    findings: tuple[Analysis, ...]
    galleries: tuple[Analysis, ...] = ()  # a heading and its figures

    def requests(self, plan: StudyPlan) -> Sequence[Request[Any]]:
        """The runs that all of them need beside the study's own."""
        every = (*self.findings, *self.galleries)
        return tuple(request for analysis in every for request in analysis.requests(plan))


def analysed(
    study: Study, section: Section, system: str, judged: Judgements
) -> tuple[Analysed, ...]:
    """The numbers of all analyses of a section, of a `system` or of "engines"; one that fails is
    left out where verdicts of the study are unexpected, and a defect where none is."""
    results = list[Analysed]()
    for analysis in (*section.findings, *section.galleries):
        place = "finding" if analysis in section.findings else "gallery"
        left_out = Analysed(analysis.template, place, system, "", None)
        try:
            if (numbers := analysis.numbers(study)) is None:
                continue
            claims = tuple(
                (claim.text, bool(claim.holds)) for claim in analysis.claims(numbers)
            )
            results.append(replace(left_out, numbers=plain(numbers), claims=claims))
        except Exception:
            if not (pairs := unexpected_pairs(study, judged)):
                raise
            results.append(replace(left_out, claims=tuple((pair, False) for pair in pairs)))
    return tuple(results)


def plain(value: Any) -> Any:
    """Numbers as a store and a template have them: records as mappings, dataclasses with their
    public properties, arrays as tuples."""
    if isinstance(value, Record):
        value = vars(value)
    if is_dataclass(value) and not isinstance(value, type):
        names = [field.name for field in fields(value)]
        names += [name for name, of in vars(type(value)).items() if isinstance(of, property)]
        return {name: plain(getattr(value, name)) for name in names}
    if isinstance(value, Mapping):
        return {str(name): plain(entry) for name, entry in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
        return value.item() if isinstance(value, np.generic) else value
    return tuple(plain(entry) for entry in value)
