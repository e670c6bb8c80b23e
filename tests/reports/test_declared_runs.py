"""The page runs no engine: it looks up exactly what its findings declared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
import pytest

from plumbob.engines.method import Trimming
from plumbob.engines.registry import engines
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.convergence import ConvergenceStudy, chosen_step_sizes
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.extra_runs import (
    ExtraRun,
    Request,
    Result,
    StudyPlan,
    TrimmingRun,
    UndeclaredRun,
)
from plumbob.engines.study.measurement import Measurement, ObservedError, Prediction
from plumbob.engines.study.runner import most_steps, pairs
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import scenes as find_scenes
from plumbob.models.registry import system_of
from plumbob.models.scene import Case
from plumbob.reports.findings import requests, section
from plumbob.reports.view.page import render
from plumbob.reports.view.trimming import trimming
from plumbob.tests.support.declared import nothing, plan_of
from plumbob.tests.support.studies import quick

SAMPLES, ERROR = 240, 1e-6


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
def no_engine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Engines that raise when a run is prepared or timed."""

    def refuses(*arguments: object) -> None:
        raise AssertionError("an engine was run")

    for engine in engines().values():
        for name in ("prepare", "trimming"):
            monkeypatch.setitem(engine.__dict__, name, refuses)


@pytest.mark.usefixtures("no_engine")
def test_the_page_of_a_small_study_runs_no_engine_and_asks_for_what_was_declared() -> None:
    asked = Asked(SMALL.extras)
    page = render(replace(SMALL, extras=asked), section)
    assert "printed-hamiltonian" in page
    assert asked.looked_up == set(requests(plan_of(SMALL)))


SMALL = quick()  # measured before the engines are taken away


@pytest.mark.usefixtures("no_engine")
def test_the_quick_profile_asks_for_what_was_declared_and_nothing_else() -> None:
    plan = StudyPlan("quick", find_scenes("*", "quick"), find_methods("*"))
    asked = Asked({request: invented(request) for request in requests(plan)})
    cost = Cost(1.0, 1.0, 1.0, 1.0, 0.0, 5)
    study = replace(
        nothing(), scenes=plan.scenes, methods=plan.methods, convergence=convergence(plan),
        costs={(s.name, m.name): cost for s, m in pairs(plan.scenes, plan.methods)}, extras=asked,
    )  # fmt: skip
    for name in dict.fromkeys(scene.system for scene in plan.scenes):
        if (own := section(name)) is not None:
            own.findings(study)
            own.figures(study)
    for scene in plan.scenes:
        trimming(study, scene)
        if scene.hard and (own := section(scene.system)) is not None:
            own.hard(study, scene)
    assert asked.looked_up == set(asked)


def test_a_run_that_was_not_declared_is_refused() -> None:
    own = section("cone-pendulum")
    assert own is not None
    with pytest.raises(UndeclaredRun, match="cone-pendulum"):
        own.findings(nothing())


@cache
def posed(name: str) -> Case:
    scene = find_scene(name)
    return system_of(scene).case(scene)


def invented(request: Request) -> Result:
    """What an engine with a small, constant error would give."""
    if isinstance(request, TrimmingRun):
        return Trimming(3.0, 2.0, 1.0, True)
    if not isinstance(request, ExtraRun):
        raise AssertionError(f"the quick profile fits its own orders: {request}")
    case = posed(request.scene)
    times = np.linspace(0.0, request.duration or case.scene.duration, SAMPLES)
    channels = {"contacts": np.full(SAMPLES, 3.0), "vertical_displacement": np.zeros(SAMPLES)}
    exact = case.reference.observe(times)
    seen = {name: values + ERROR for name, values in exact.items()}
    return Trajectory(times, seen, channels, steps=SAMPLES)


def convergence(plan: StudyPlan) -> tuple[ConvergenceStudy, ...]:
    """A made-up study of every pair: errors of first order, as predicted."""
    found = []
    for scene, method in pairs(plan.scenes, plan.methods):
        names = [observable.name for observable in system_of(scene).observables]
        runs = tuple(
            Measurement(
                scene.name, method.name, step, "done", steps=1,
                channels={"vertical_displacement": step},
                errors={n: ObservedError(step, step, 1e-16, 1.0,
                                         predicted=Prediction(step, step, {1: step}, 0.0))
                        for n in names},
            )
            for step in chosen_step_sizes(scene, method, most_steps(scene, plan.profile))
        )  # fmt: skip
        found.append(ConvergenceStudy(scene.name, method.name, runs))
    return tuple(found)
