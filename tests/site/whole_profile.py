"""What the pages show of the whole quick profile, invented and not run, and of a small study that
was measured: made once a run, with engines that refuse to run, for all that look."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache

import pytest

from plumbob.engines.registry import engines
from plumbob.engines.study.extra_runs import Request, Result
from plumbob.engines.study.results import Study
from plumbob.reports.findings import requests, section
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
    with no_engine():
        return invented_study(requests)


@cache
def shown() -> Content:
    """What its pages show, and what they asked for: its study's extras are `Asked`."""
    return shared("whole-pages", lambda: _shown(study()))


@cache
def small() -> Content:
    """The same of the small study that is measured."""
    return shared("small-pages", lambda: _shown(quick()))


def _shown(study: Study) -> Content:
    with no_engine():
        return content(replace(study, extras=Asked(study.extras)), section)
