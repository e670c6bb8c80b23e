"""What an analysis is: runs that it needs, numbers of a study, checks of them, and a template."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from plumbob.engines.study.codec import to_json
from plumbob.engines.study.extra_runs import Request, Requests, StudyPlan, nothing_more
from plumbob.engines.study.results import Analysed, Study
from plumbob.models.scene import Case
from plumbob.reports.judge.study_verdicts import Judgements, unexpected
from plumbob.reports.view.content import Claim, Figure, Finding, Table

Numbers = Any
"""A frozen dataclass of numbers, texts, arrays, and dataclasses and sequences and mappings of
them; None where a study lacks what the analysis is about."""


def _nothing(numbers: Numbers) -> Sequence[Claim]:
    return ()


@dataclass(frozen=True)
class Analysis:
    """An analysis of a study, with the template that holds all its words, tables and figures."""

    template: str  # "cone_pendulum/equilibria" of reports/templates
    numbers: Callable[..., Numbers]  # of a study; of a study and a scene, for a hard scene
    requests: Requests = nothing_more  # runs beside the study's own
    claims: Callable[[Numbers], Sequence[Claim]] = _nothing  # that its words rest on


@dataclass(frozen=True)
class Section:
    """The analyses of one system, by their places on its pages."""

    findings: tuple[Any, ...]
    galleries: tuple[Any, ...] = ()  # a heading and its figures
    hard: tuple[Any, ...] = ()  # on the pages of hard scenes: numbers(study, scene)
    more: Requests = nothing_more  # runs of those that do not declare them themselves
    solved: tuple[str, Callable[[Case], Numbers]] | None = None
    """The source's figures for a case with parameters of the user's own: template and numbers."""

    def requests(self, plan: StudyPlan) -> Sequence[Request]:
        """The runs that all of them need beside the study's own."""
        every = (*self.findings, *self.galleries, *self.hard)
        own = [one.requests(plan) for one in every if isinstance(one, Analysis)]
        return (*self.more(plan), *(request for requests in own for request in requests))


def analysed(
    study: Study, section: Section, system: str, judged: Judgements
) -> tuple[Analysed, ...]:
    """The numbers of all analyses of a section, of a `system` or of "engines"; one that fails is
    left out where verdicts of the study are unexpected, and a defect where none is."""
    hard = [scene for scene in study.scenes if scene.hard and scene.system == system]
    asked: list[tuple[str, Any, tuple[Any, ...]]] = [
        *(("finding", analysis, (study,)) for analysis in section.findings),
        *(("gallery", analysis, (study,)) for analysis in section.galleries),
        *(("hard", analysis, (study, scene)) for scene in hard for analysis in section.hard),
    ]
    results = list[Analysed]()
    for place, analysis, arguments in asked:
        empty = Analysed("", place, system, arguments[1].name if arguments[1:] else "", None)
        try:
            if isinstance(analysis, Analysis):
                results += _numbers(analysis, arguments, empty)
            else:
                results += _formed(analysis, arguments, empty)
        except Exception:
            if not (pairs := unexpected(study, judged)):
                raise
            results.append(replace(empty, claims=tuple((pair, False) for pair in pairs)))
    return tuple(results)


def _numbers(
    analysis: Analysis, arguments: tuple[Any, ...], empty: Analysed
) -> tuple[Analysed, ...]:
    numbers = analysis.numbers(*arguments)
    if numbers is None:
        return ()
    claims = tuple((claim.text, bool(claim.holds)) for claim in analysis.claims(numbers))
    return (replace(empty, template=analysis.template, numbers=plain(numbers), claims=claims),)


def _formed(
    form: Callable[..., Any], arguments: tuple[Any, ...], empty: Analysed
) -> tuple[Analysed, ...]:
    """Findings that are formed as a whole, until each has numbers and a template."""
    formed = form(*arguments)
    if formed is None:
        return ()
    if empty.place == "gallery":
        whole = [Finding("", heading, "", "", figures=tuple(drawn)) for heading, drawn in formed]
    elif empty.place == "hard":
        drawn = tuple(part for part in formed if isinstance(part, Figure))
        tables = tuple(part for part in formed if isinstance(part, Table))
        whole = [Finding("", "", "", "", tables=tables, figures=drawn)]
    else:
        whole = [formed]
    return tuple(replace(empty, numbers=json.loads(to_json(finding))) for finding in whole)


def plain(value: Any) -> Any:
    """Numbers as a store and a template have them: dataclasses as mappings, with their public
    properties, arrays as tuples."""
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
