"""What `validate` tells a person and a CI system, and engines that are sabotaged for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from xml.etree import ElementTree

import pytest

from plumbob.engines import registry
from plumbob.engines.known_limits import Limits
from plumbob.engines.method import KnownLimit, Method, Simulation, Stepping, Unsupported
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case
from plumbob.reports.cli import main
from plumbob.reports.judge import expectations

Prepare = Callable[[Case, Method, float], Simulation]


@dataclass(frozen=True)
class Outcome:
    """Exit code of a `validate`, what it printed, and its JUnit file."""

    code: int
    out: str
    junit: ElementTree.Element

    def case(self, scene: str, method: str) -> ElementTree.Element:
        """The test case of a scene and method."""
        (found,) = self.junit.findall(f"testcase[@classname='{scene}'][@name='{method}']")
        return found

    def properties(self, scene: str, method: str) -> dict[str, str]:
        """The properties of a test case."""
        held = self.case(scene, method).findall("properties/property")
        return {one.attrib["name"]: one.attrib["value"] for one in held}

    def failure(self, scene: str, method: str) -> str:
        """Why a test case fails; nothing where it does not."""
        found = self.case(scene, method).find("failure")
        return "" if found is None else found.attrib["message"]


def validated(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    scenes: str,
    methods: str,
    more: Sequence[str] = (),
) -> Outcome:
    """The outcome of a `validate` in this process, with its files in `folder`."""
    file = folder / "junit.xml"
    code = main(
        (
            "validate",
            "--scenes",
            scenes,
            "--methods",
            methods,
            "--jobs",
            "1",
            "--out",
            str(folder / "out"),
            "--junitxml",
            str(file),
            *more,
        )
    )
    said = capsys.readouterr()
    assert file.exists(), said.err
    return Outcome(code, said.out, ElementTree.parse(file).getroot())


def without_pages(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let studies make no runs but their own, and draw no page."""
    monkeypatch.setattr("plumbob.reports.analyses.requests", lambda plan: ())
    monkeypatch.setattr("plumbob.reports.analyses.analyses_of", lambda study, jobs, judged: ())
    monkeypatch.setattr(
        "plumbob.reports.view.site.writing.write_page",
        lambda study, out, *more: out / "none",
    )


def without_findings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let pages say of each system what they say of every one, and studies make no other runs."""
    monkeypatch.setattr("plumbob.reports.analyses.section", lambda system: None)


def with_prepare(
    monkeypatch: pytest.MonkeyPatch, name: str, made: Callable[[Prepare], Prepare]
) -> None:
    """Let the engine of this name prepare what `made` makes of its own way to."""
    engine = registry.built_in()[name]
    broken = {**registry.built_in(), name: replace(engine, prepare=made(engine.prepare))}
    monkeypatch.setattr(registry, "built_in", lambda: MappingProxyType(broken))


def break_engine(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """Let this engine refuse every model."""

    def refuse(case: Case, method: Method, step: float) -> Simulation:
        raise Unsupported("the compiler refuses this model")

    with_prepare(monkeypatch, name, lambda prepare: refuse)


def misread(monkeypatch: pytest.MonkeyPatch, name: str, factors: Mapping[str, float]) -> None:
    """Let this engine read parameters as so many times their values."""

    def wrong(prepare: Prepare) -> Prepare:
        def reading(case: Case, method: Method, step: float) -> Simulation:
            scene, system = case.scene, case.system
            changes = {p: scene.parameters[p] * factor for p, factor in factors.items()}
            parameters = system.change(scene.parameters, changes)
            return prepare(system.case(replace(scene, parameters=parameters)), method, step)

        return reading

    with_prepare(monkeypatch, name, wrong)


@dataclass(frozen=True)
class Changed:
    """A simulation whose trajectories are changed afterwards."""

    own: Simulation
    change: Callable[[Trajectory], Trajectory]

    @property
    def compile_seconds(self) -> float:
        """As it was."""
        return self.own.compile_seconds

    def run(self) -> Trajectory:
        """The changed trajectory."""
        return self.change(self.own.run())

    def stepped(self, fraction: float) -> Stepping:
        """As it was."""
        return self.own.stepped(fraction)


def changed_runs(
    monkeypatch: pytest.MonkeyPatch, name: str, change: Callable[[Case, Trajectory], Trajectory]
) -> None:
    """Let this engine's runs come back as `change` makes them."""

    def wrong(prepare: Prepare) -> Prepare:
        def changing(case: Case, method: Method, step: float) -> Simulation:
            return Changed(prepare(case, method, step), lambda run: change(case, run))

        return changing

    with_prepare(monkeypatch, name, wrong)


def declare(monkeypatch: pytest.MonkeyPatch, *limits: KnownLimit) -> None:
    """Put these limits before those of every engine."""

    def with_these(method: str) -> Limits:
        declared = registry.limits_of(method)
        return replace(declared, known_limits=(*limits, *declared.known_limits))

    monkeypatch.setattr(expectations, "limits_of", with_these)
