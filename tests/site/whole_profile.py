"""What the pages show of the whole quick profile, invented and not run, and of a small study that
was measured: made once a run, with engines that refuse to run, for all that look."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
import pytest

from plumbob.engines.registry import engines
from plumbob.engines.study.extra_runs import Request, Result
from plumbob.engines.study.results import Study
from plumbob.models.registry import system_of
from plumbob.reports.analyses import analyses_of, requests
from plumbob.reports.analyses.capsule_plan import legs, poses
from plumbob.reports.analyses.capsule_plan.plans import plan_of
from plumbob.reports.judge.sensitivity import Parameter, Sensitivities, Slopes, parameters_of
from plumbob.reports.view.content import Finding
from plumbob.reports.view.finding_text import findings_of
from plumbob.reports.view.site.writing import Content, content
from plumbob.tests.sharing.shared import shared
from plumbob.tests.support.declared import invented_study
from plumbob.tests.support.studies import quick


@dataclass(frozen=True)
class Asked(Mapping[Request, Result]):
    """Results of declared requests, with a record of those that were looked up."""

    results: Mapping[Request, Result]
    looked_up: set[Request] = field(default_factory=set)

    def __getitem__(self, request: Request) -> Result:
        found = self.results[request]
        self.looked_up.add(request)
        return found

    def __iter__(self) -> Iterator[Request]:
        return iter(self.results)

    def __len__(self) -> int:
        return len(self.results)


@contextmanager
def no_engine() -> Iterator[None]:
    """Engines that raise when a run is prepared or timed."""

    def refuses(*arguments: object) -> None:
        raise AssertionError("an engine was run")

    with pytest.MonkeyPatch.context() as patched:
        for engine in engines().values():
            for name in ("prepare", "trimming"):
                patched.setitem(engine.__dict__, name, refuses)
        yield


@cache
def study() -> Study:
    """Every scene and method of the quick profile with errors of first order: their places on the
    pages are those of a measured study, and most are unexpected."""
    return shared("whole-study", _invented)


def _invented() -> Study:
    with no_engine(), one_plan():
        return invented_study(requests)


@contextmanager
def one_plan() -> Iterator[None]:
    """Findings on plans take one for all: to look for the others takes longer than all the rest."""
    shown = legs.SCENES[1]
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(legs, "SCENES", (shown, shown))
        patched.setattr(legs, "plans", lambda: (plan_of(shown), plan_of(shown)))
        patched.setattr(poses, "naive", plan_of)
        yield


@cache
def shown() -> Content:
    """What its pages show, and what they asked for: its study's extras are `Asked`."""
    return _whole()[0]


def findings() -> tuple[Finding, ...]:
    """The findings of its pages, as they are where all that they claim holds."""
    return _whole()[1]


@cache
def small() -> Content:
    """The same of the small study that is measured."""
    return shared("small-pages", lambda: _shown(quick()))[0]


@cache
def _whole() -> tuple[Content, tuple[Finding, ...]]:
    """Without the exact motions of every changed parameter, which take half of the time."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Sensitivities, "slopes", property(_even))
        return shared("whole-pages", lambda: _shown(study()))


def _even(sensitivities: Sensitivities) -> Mapping[Parameter, Slopes]:
    """Slopes that are as invented as the study: 1 for every parameter and observable."""
    scene = sensitivities.scene
    ones = {observable.name: np.ones(1) for observable in system_of(scene).observables}
    return dict.fromkeys(parameters_of(scene), ones)


def _shown(study: Study) -> tuple[Content, tuple[Finding, ...]]:
    """What the pages of a study show, and the findings before it is seen whether they hold."""
    asked = replace(study, extras=Asked(study.extras))
    with no_engine(), one_plan():
        analysed = analyses_of(asked)
        pages = content(replace(asked, analyses=analysed))
    kept = [finding for a in analysed if a.place == "finding" for finding in findings_of(a)]
    return pages, tuple(kept)
