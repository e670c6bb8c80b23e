"""Views of a site's pages: one a scene, and one a system."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from types import SimpleNamespace
from typing import Any, get_args

from plumbob.engines.method import Method
from plumbob.engines.study.measurement import Measurement, reference_run
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import DEFAULT_METHOD, EXACT
from plumbob.reports.judge.verdict import Verdict
from plumbob.reports.view import hard_cases, notation, scene_tables, top_tables
from plumbob.reports.view.about import described
from plumbob.reports.view.palette import styles
from plumbob.reports.view.plots import error_against_cost, scene_figures
from plumbob.reports.view.records import (
    ExactRecord,
    PairVerdict,
    Records,
    SceneRecord,
    SystemRecord,
)
from plumbob.reports.view.site import matrix, scene_answer
from plumbob.reports.view.site.claims import formed, galleries
from plumbob.reports.view.step_ranges import finite_limits, step_ranges
from plumbob.reports.view.tables import table_or_none
from plumbob.reports.view.top_tables import anchor
from plumbob.reports.view.trimming import trimming

View = SimpleNamespace
"""A scene or a system as its page shows it, by the names that a template reads."""
OF_ENGINES = "engines"  # the section of what holds for engines, whatever the system, and its page
DERIVATIVES = "engines/gradients"  # the analysis that has those of every scene


def in_order(study: Study, system: SystemRecord) -> list[Scene]:
    """The scenes of a system that `study` has: the one that stands for it first, hard ones last."""
    scenes = [scene for scene in study.scenes if scene.system == system.name]
    default = f"{system.name}/{system.default}"
    return sorted(scenes, key=lambda scene: (scene.name != default, bool(scene.hard)))


def system_view(study: Study, records: Records, system: SystemRecord, every: matrix.Every) -> View:
    """One system with the scenes of `study`, with the errors of `every` method on every scene."""
    scenes = in_order(study, system)
    exact = {name: of for name, record in records.scenes.items() if (of := record.exact)}
    views = tuple(
        scene_view(study, records.scenes[scene.name], exact[scene.name], scene, every)
        for scene in scenes
        if scene.name in exact
    )
    return View(
        system=system,
        about=described(system.name),
        galleries=galleries(study, system.name),
        findings=formed(study, system.name),
        scenes=views,  # the one that stands for the system first
        leading=views[0] if views else None,  # whose measurements the system's page shows
        matrices=matrix.matrices(study, every, scenes),
        hard=hard_cases.table(study, [(of.scene, of.ranges) for of in views if of.scene.hard]),
    )


def scene_view(
    study: Study, record: SceneRecord, exact: ExactRecord, scene: Scene, every: matrix.Every
) -> View:
    """One scene of `study`, with the errors of `every` method on every scene."""
    methods = {method.name: method for method in study.methods}
    missing = [name for name, of in record.verdicts.items() if of.verdict == "missing"]
    judged = {name: of for name, of in record.verdicts.items() if name not in missing}
    convergence = [c for c in study.convergence if c.scene == scene.name and c.method in judged]
    costs = {name: cost for (of, name), cost in study.costs.items() if of == scene.name}
    ran = [c.method for c in convergence if any(m.status == "done" for m in c.measurements)]
    at_first = _at_first(record, [methods[name] for name in ran])
    observables, ranges = study.observables(scene.name), step_ranges(study, scene)
    digits = hard_cases.table(study, [(scene, ranges)])
    cells = {name: of for (where, name), of in every.items() if where == scene.name}
    tables_below = (
        top_tables.scene_recommendations(record.recommendations),
        scene_tables.orders(convergence, methods),
        table_or_none("gradients", records=_derivatives(study, scene.name)),
        trimming(study, scene),
        scene_tables.cost(convergence, costs, methods),
        scene_tables.budgets(observables, convergence, judged, methods),
        scene_tables.every_run(observables, convergence, judged, methods),
        scene_tables.parameters(scene.parameters, exact.facts, scene.source),
    )
    looks = styles(study.methods)
    speed = error_against_cost(record.points, methods, looks, finite_limits(ranges))
    best = next((c for c in convergence if at_first and c.method == at_first[-1]), None)
    typical = None if best is None else reference_run(best.measurements, methods[best.method])
    return View(
        scene=scene,
        anchor=anchor(scene.name),
        counts=_counts(judged.values()),  # verdicts, and how many methods have each
        missing=_by_engine(missing),  # engines that are not installed, with their methods' number
        methods=tuple(ran),
        at_first=at_first,  # methods whose curves are drawn before a reader chooses others
        sentences=scene_answer.sentences(
            convergence, study.quantities(scene.name), cells, record.recommendations
        ),
        first=scene_answer.errors(convergence, cells, judged, record.points, methods),
        figures=scene_figures(
            observables, convergence, methods, looks, exact.motion, speed, ranges
        ),
        replay=exact.replay,
        hard=digits if scene.hard or any(of.limit for of in ranges) else None,
        ranges=ranges,  # of its methods
        rest=tuple(t for t in tables_below if t),
        commands=_commands(scene, typical),
    )


def _derivatives(study: Study, scene: str) -> list[Any]:
    """Those of what a scene's runs end with, way by way."""
    judged = [
        a.numbers["records"] for a in study.analyses if a.template == DERIVATIVES and a.numbers
    ]
    return [of for records in judged for of in records if of["scene"] == scene]


def _by_engine(methods: Sequence[str]) -> tuple[str, ...]:
    """Engines of methods, each with how many of them it has."""
    counted = Counter(name.partition("/")[0] for name in methods)
    return tuple(f"{engine} ({notation.plural(n, 'method')})" for engine, n in counted.items())


def _commands(scene: Scene, run: Measurement | None) -> tuple[str, ...]:
    """The commands that repeat what a scene's page shows, one `run` of it among them."""
    repeated = (f"plumbob run {run.scene} {run.method} --step {run.step:g}",) if run else ()
    return (
        f"plumbob solve {scene.name}",
        *repeated,
        f"plumbob recommend {scene.name} --error 1e-3",
        f"plumbob validate --scenes {scene.name}",
    )


def _at_first(record: SceneRecord, ran: Sequence[Method]) -> tuple[str, ...]:
    """MuJoCo's default settings, and of each engine the cheapest method for a small error, or else
    the one with the smallest error; no closed form, which is no curve."""
    best: dict[str, str] = {}
    simulated = [m for m in ran if m.scheme.integrator != EXACT]
    for method in sorted(simulated, key=lambda m: _smallest(record, m)):
        best.setdefault(method.engine, method.name)
    for answer in record.recommendations:
        if answer.error == scene_answer.WANTED:
            best |= {choice.method.partition("/")[0]: choice.method for choice in answer.by_engine}
    names = {m.name for m in ran}
    return tuple(name for name in dict.fromkeys((DEFAULT_METHOD, *best.values())) if name in names)


def _smallest(record: SceneRecord, method: Method) -> tuple[bool, float]:
    """Sorts full models first, then small errors."""
    error = record.verdicts[method.name].smallest
    return bool(method.surrogate), math.inf if error is None else error


def _counts(judged: Iterable[PairVerdict]) -> tuple[tuple[str, int], ...]:
    """Verdicts, and how many methods have each, in the page's order."""
    counted = Counter(result.verdict for result in judged)
    return tuple((verdict, counted[verdict]) for verdict in get_args(Verdict) if counted[verdict])
