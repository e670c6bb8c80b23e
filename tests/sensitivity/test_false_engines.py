"""Engines that are wrong and hide it: the heading of the start is left out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest

from plumbob.engines.method import Method
from plumbob.engines.registry import engine_of, engines, installed, methods
from plumbob.engines.study import measurement
from plumbob.engines.study.measurement import measure
from plumbob.engines.study.runner import pairs
from plumbob.models.registry import case_of, scenes, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case, Scene
from plumbob.reports.judge.expectations import run_surprise
from plumbob.reports.judge.tolerance import STARTS_OFF
from plumbob.reports.judge.unjudged import declared
from plumbob.reports.judge.verdict import Judgement, judge

TURNED = (
    *(s for s in scenes("capsule-*/heading-*") if s.name != "capsule-line/heading-000"),
    find_scene("capsule-hold/0.999", {"heading": -2.0}),
    find_scene("capsule-coast/spin", {"heading": -2.0}),
    find_scene("capsule-coast/translation", {"heading": -2.0}),
    find_scene("capsule-train/ten", {"heading": 9.0}),
)
ENGINES = tuple(
    name for name, engine in engines().items() if installed(engine) and pairs(TURNED, methods(name))
)
Changed = Callable[[Case], Case]


def changing(monkeypatch: pytest.MonkeyPatch, change: Changed) -> None:
    """Have every engine build and read another case."""

    def false(method: Method) -> object:
        true = engine_of(method)
        return replace(
            true, prepare=lambda case, method, step: true.prepare(change(case), method, step)
        )

    monkeypatch.setattr(measurement, "engine_of", false)


def without_heading(case: Case) -> Case:
    setup = replace(case.problem.setup, heading=0.0)
    return replace(case, problem=replace(case.problem, setup=setup))


@pytest.mark.parametrize("engine", ENGINES)
def test_no_engine_leaves_the_heading_out(engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each run of a scene that is turned is unexpected where the engine's body is not, known limits
    too, though all but the heading is as in the scene that is not turned."""
    changing(monkeypatch, without_heading)
    for scene, method, verdict in _runs(engine):
        assert verdict.reason.startswith(f"{STARTS_OFF}: heading"), (scene.name, method.name)
        assert run_surprise(scene, method, verdict), (scene.name, method.name)


@pytest.mark.parametrize("engine", ENGINES)
def test_every_engine_turns_its_body(engine: str) -> None:
    for scene, method, verdict in _runs(engine):
        assert not verdict.reason.startswith(STARTS_OFF), (scene.name, method.name, verdict.reason)


def _runs(engine: str) -> Iterator[tuple[Scene, Method, Judgement]]:
    """The verdicts on a run of each turned scene, with the methods that give a heading of it."""
    for scene, method in pairs(TURNED, methods(engine)):
        steps = method.step_sizes if method.control == "tolerance" else scene.steps
        found, _ = measure(case_of(scene), method, steps[0])
        if found.status != "unsupported" and "heading" not in declared(scene.name, method.name):
            yield scene, method, judge(found, system_of(scene), method)
