"""What `validate` tells a person and a CI system, and engines that are sabotaged for it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import MappingProxyType
from xml.etree import ElementTree

from plumbob.analytic.schemes import Scheme
from plumbob.engines import registry
from plumbob.engines.abilities import SchemeOfCase
from plumbob.engines.method import Simulation, Unsupported
from plumbob.engines.study.results import Analysed
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.page_numbers import verdict_on
from plumbob.reports.cli import main
from plumbob.reports.judge import expectations
from plumbob.reports.records.page_records import PAGES_OF_STUDY, SCENE, SceneRecord, StudyRecord


@dataclass(frozen=True)
class Outcome:
    """Exit code of a `validate`, what it printed, and its JUnit file."""

    code: int
    out: str
    junit: ElementTree.Element

    def case(self, scene, method):
        """The test case of a scene and method."""
        (found,) = self.junit.findall(f"testcase[@classname='{scene}'][@name='{method}']")
        return found

    def properties(self, scene, method):
        """The properties of a test case."""
        held = self.case(scene, method).findall("properties/property")
        return {one.attrib["name"]: one.attrib["value"] for one in held}

    def failure(self, scene, method):
        """Why a test case fails; nothing where it does not."""
        found = self.case(scene, method).find("failure")
        return "" if found is None else found.attrib["message"]


def validated(folder, capsys, scenes, methods, more=()):
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


def without_pages(monkeypatch):
    """Let studies make no runs but their own, and draw no page."""
    monkeypatch.setattr("plumbob.reports.analyses.requests", lambda plan, pairs_alone: ())
    monkeypatch.setattr("plumbob.reports.analyses.analyses_of", _verdicts_alone)
    monkeypatch.setattr(
        "plumbob.reports.view.site.writing.write_study_pages",
        lambda study, out, *more: out / "none",
    )


def _verdicts_alone(study, jobs, judged, progress):
    """The records of a study's pages with its verdicts and nothing else."""
    verdicts = {scene.name: {} for scene in study.scenes}
    for c in study.convergence:
        verdicts[c.scene][c.method] = verdict_on(study, c, judged)
    pages = {name: SceneRecord(of, (), None) for name, of in verdicts.items()}
    scenes = [Analysed("", SCENE, "", name, numbers) for name, numbers in pages.items()]
    return (*scenes, Analysed("", PAGES_OF_STUDY, "", "", StudyRecord((), {}, {}, ())))


def without_findings(monkeypatch):
    """Let pages say of each system what they say of every one, and studies make no other runs."""
    monkeypatch.setattr("plumbob.reports.analyses.section", lambda system: None)


def with_prepare(monkeypatch, name, made):
    """Let the engine of this name prepare what `made` makes of its own way to."""
    engine = registry.built_in()[name]
    with_engine(monkeypatch, replace(engine, prepare=made(engine.prepare)))


def with_engine(monkeypatch, engine):
    """Let this engine take the place of the one of its name."""
    every = MappingProxyType({**registry.built_in(), engine.name: engine})
    monkeypatch.setattr(registry, "built_in", lambda: every)
    monkeypatch.setattr(registry, "_adapter", every.get)


def without_theory(monkeypatch):
    """Let MuJoCo's methods have a scheme that no theory knows."""
    mujoco = registry.built_in()["mujoco"]
    other = SchemeOfCase(lambda case, method: Scheme("own"))
    with_engine(monkeypatch, replace(mujoco, abilities=(other, *mujoco.abilities)))


def break_engine(monkeypatch, name):
    """Let this engine refuse every model."""

    def refuse(case, method, step):
        raise Unsupported("the compiler refuses this model")

    with_prepare(monkeypatch, name, lambda prepare: refuse)


def misread(monkeypatch, name, factors):
    """Let this engine read parameters as so many times their values."""

    def wrong(prepare):
        def reading(case, method, step):
            scene = case.scene
            system = case.system
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
    def compile_seconds(self):
        """As it was."""
        return self.own.compile_seconds

    def run(self):
        """The changed trajectory."""
        return self.change(self.own.run())

    def stepped(self, fraction):
        """As it was."""
        return self.own.stepped(fraction)


def changed_runs(monkeypatch, name, change):
    """Let this engine's runs come back as `change` makes them."""

    def wrong(prepare):
        def changing(case, method, step):
            return Changed(prepare(case, method, step), lambda run: change(case, run))

        return changing

    with_prepare(monkeypatch, name, wrong)


def declare(monkeypatch, *limits):
    """Put these limits before those of every engine."""

    def with_these(method):
        declared = registry.limits_of(method)
        return replace(declared, known_limits=(*limits, *declared.known_limits))

    monkeypatch.setattr(expectations, "limits_of", with_these)
