"""The first screen of the index: counts of verdicts, recommended settings and key findings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from fnmatch import fnmatch
from statistics import median_high
from typing import NamedTuple

from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import DEFAULT_METHOD
from plumbob.reports.records import notation
from plumbob.reports.records.page_records import StudyRecord
from plumbob.reports.view.content import Finding
from plumbob.reports.view.method_results import Results, ShownError
from plumbob.reports.view.settings import titled_settings
from plumbob.reports.view.site.claims import NOT_SHOWN
from plumbob.reports.view.site.matrix import sorted_scenes
from plumbob.reports.view.site.views import PageView
from plumbob.reports.view.tables import paragraphs

MOST_FINDINGS = 5


class RobotKind(NamedTuple):
    """A kind of robot for which the first screen recommends settings."""

    name: str
    title: str
    settings_title: str
    systems: str  # pattern of the systems of this kind
    first_systems: str  # pattern of the systems whose errors the first sentences state
    methods: tuple[
        str, ...
    ]  # default, recommended, and perhaps a third for more kinds of motion


KINDS = (
    RobotKind(
        name="with-contacts",
        title="A robot with contacts",
        settings_title="Contacts to copy",
        systems="capsule-*",
        first_systems="capsule-line",
        methods=(DEFAULT_METHOD, "mujoco/euler+coulomb", "mujoco/rk4+coulomb"),
    ),
    RobotKind(
        name="without-contacts",
        title="A robot without contacts",
        settings_title="Integrator to copy",
        systems="*pendulum",
        first_systems="*",
        methods=(DEFAULT_METHOD, "mujoco/rk4"),
    ),
)
SceneErrors = tuple[Scene, Mapping[str, ShownError]]  # errors at the reference step, by method


def meanings_by_engine(all_results: Results) -> Mapping[str, Counter[str]]:
    """Counts of meanings ("predicted", "converges", …) over the pairs of scene and method, for each
    engine that ran."""
    engines: dict[str, Counter[str]] = {}
    for result in all_results.values():
        if result.meaning != "not-run":
            engines.setdefault(result.method.engine, Counter())[result.meaning] += 1
    return engines


def run_counts(all_results: Results) -> tuple[int, int, int]:
    """Numbers of runs, of scenes and of methods that ran."""
    results = [result for result in all_results.values() if result.errors]
    scenes = {result.scene.name for result in results}
    methods = {result.name for result in results}
    return sum(len(result.errors) for result in results), len(scenes), len(methods)


def key_findings(findings: Sequence[Finding]) -> Sequence[Finding]:
    """At most `MOST_FINDINGS` findings with a figure, the key findings first. Other findings
    replace the key findings that the study lacks or does not show."""
    shown = [f for f in findings if f.judgement != NOT_SHOWN and f.figures]
    keys = sorted((f for f in shown if f.key), key=lambda finding: finding.key)
    return [*keys, *(f for f in shown if not f.key)][:MOST_FINDINGS]


def recommended_settings(
    study: Study, record: StudyRecord, all_results: Results
) -> Sequence[PageView]:
    """A view for each kind of robot, with and without contacts: the recommended settings, their
    measured errors and their measured costs. A kind without any usual scene is left out."""
    views = []
    for kind in KINDS:
        methods = kind.methods
        default = methods[0]
        better = methods[1]
        ordered = sorted_scenes(study.scenes, record.systems)
        scenes = [scene for scene in ordered if fnmatch(scene.system, kind.systems)]
        ran = _errors_of_all(all_results, scenes, methods)

        unusual = [row for row in ran if _is_unusual(row[0])]
        usual = [row for row in ran if row not in unusual]
        first = [row for row in usual if fnmatch(row[0].system, kind.first_systems)]
        if not first:
            continue
        costs = _median_costs(study, [scene for scene, _ in ran], methods)
        ratios = {n: notation.number(ns / costs[default], 2) for n, ns in costs.items()}
        turning = methods[-1] if methods[-1] in ratios else better
        sentences = paragraphs(
            kind.name.replace("-", "_"),
            methods=methods,
            usual=_by_error(first, default),
            best=_by_error(first, better),
            turning=_by_error(usual, turning),
            ratios=ratios,
            apart=[
                (method, _by_error(unusual, method)) for method in (turning, default) if unusual
            ],
        )
        cost = ratios.get(better, "")
        pasted = titled_settings(record.settings[better], kind.settings_title, cost)
        views.append(
            PageView(name=kind.name, title=kind.title, sentences=sentences, pasted=pasted)
        )
    return views


def _is_unusual(scene: Scene) -> bool:
    """Returns whether a scene is hard or frictionless, and so not typical of a robot."""
    return bool(scene.hard) or scene.parameters.get("friction") == 0.0


def _errors_of_all(
    all_results: Results, scenes: Sequence[Scene], methods: Sequence[str]
) -> list[SceneErrors]:
    """The scenes that all `methods` ran, in the order of their systems, each with the errors of
    these methods at the reference step. The first method is the default. The others are
    recommended, and have the largest of their errors at that step and at smaller steps."""
    ran = list[SceneErrors]()
    for scene in scenes:
        errors = dict[str, ShownError]()
        for name in methods:
            result = all_results.get((scene.name, name))
            if result is None:
                continue
            shown = result.at_reference if name == methods[0] else result.largest_at_reference
            if shown:
                errors[name] = shown
        if len(errors) == len(methods):
            ran.append((scene, errors))
    return ran


def _by_error(ran: Sequence[SceneErrors], method: str) -> list[tuple[Scene, ShownError]]:
    """The scenes with the error of one method, sorted from the smallest error to the largest."""
    pairs = [(scene, errors[method]) for scene, errors in ran]
    return sorted(pairs, key=lambda pair: pair[1].error)


def _median_costs(
    study: Study, scenes: Sequence[Scene], methods: Sequence[str]
) -> Mapping[str, float]:
    """The median cost of a step [ns] of each method, over the scenes on which all `methods` were
    timed; empty if there is no such scene."""
    timed = [s.name for s in scenes if all((s.name, name) in study.costs for name in methods)]
    return {
        name: median_high(study.costs[scene, name].ns_per_step for scene in timed)
        for name in methods
        if timed
    }
