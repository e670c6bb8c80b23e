"""The page runs no engine: it looks up exactly what its findings declared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest

from plumbob.engines.registry import engines
from plumbob.engines.study.extra_runs import Request, Result, UndeclaredRun
from plumbob.engines.study.results import Study
from plumbob.reports.findings import requests, section
from plumbob.reports.view.replay import replay
from plumbob.reports.view.site.writing import render
from plumbob.reports.view.trimming import trimming
from plumbob.tests.support.declared import invented_study, nothing, plan_of
from plumbob.tests.support.page_document import resolve
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


@pytest.fixture
def small() -> Study:
    """The small study, to be measured before the engines are taken away."""
    return quick()


@pytest.fixture
def no_engine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Engines that raise when a run is prepared or timed."""

    def refuses(*arguments: object) -> None:
        raise AssertionError("an engine was run")

    for engine in engines().values():
        for name in ("prepare", "trimming"):
            monkeypatch.setitem(engine.__dict__, name, refuses)


@pytest.mark.usefixtures("small", "no_engine")
def test_the_page_of_a_small_study_runs_no_engine_and_asks_for_what_was_declared(
    small: Study,
) -> None:
    asked = Asked(small.extras)
    page = render(replace(small, extras=asked), section)
    assert "printed-hamiltonian" in page
    assert asked.looked_up == set(requests(plan_of(small)))


@pytest.mark.usefixtures("no_engine")
def test_the_quick_profile_asks_for_what_was_declared_and_nothing_else() -> None:
    whole = invented_study(requests)
    asked = Asked(whole.extras)
    study = replace(whole, extras=asked)
    for name in dict.fromkeys(scene.system for scene in study.scenes):
        if (own := section(name)) is not None:
            for finding in own.findings(study):
                for command in finding.commands:
                    resolve(command, Path())
            own.figures(study)
    for scene in study.scenes:
        trimming(study, scene)
        replay(study, scene)
        if scene.hard and (own := section(scene.system)) is not None:
            own.hard(study, scene)
    assert asked.looked_up == set(asked)


def test_a_run_that_was_not_declared_is_refused() -> None:
    own = section("cone-pendulum")
    assert own is not None
    with pytest.raises(UndeclaredRun, match="cone-pendulum"):
        own.findings(nothing())
