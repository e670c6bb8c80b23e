"""Views: the values that the templates of scene pages and of system pages read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any, get_args

from plumbob.engines.study.measurement import reference_run
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import DEFAULT_METHOD, EXACT, Recommendation
from plumbob.reports.advice.work_precision import points
from plumbob.reports.judge.verdict import Verdict
from plumbob.reports.view import hard_cases, notation, top_tables
from plumbob.reports.view.about import described
from plumbob.reports.view.method_results import MethodResult, Results
from plumbob.reports.view.palette import styles
from plumbob.reports.view.plots import scene_figures
from plumbob.reports.view.records import ExactRecord, Records, SceneRecord, SystemRecord
from plumbob.reports.view.site import matrix
from plumbob.reports.view.site.claims import formed
from plumbob.reports.view.tables import paragraphs, table, table_or_none
from plumbob.reports.view.top_tables import anchor
from plumbob.reports.view.trimming import trimming

View = SimpleNamespace
"""The content of a scene's or a system's page; its attributes are the names in the template."""
# section and page with the findings on engines that hold for every system
OF_ENGINES = "engines"
WANTED = 1e-3  # relative error for which a scene's page recommends a method
DERIVATIVES = (
    "engines/gradients"  # template of the analysis with the derivatives of every scene
)


def in_order(study: Study, system: SystemRecord) -> list[Scene]:
    """Returns the scenes of `system` in `study`: its default scene first, hard scenes last."""
    scenes = [scene for scene in study.scenes if scene.system == system.name]
    default = f"{system.name}/{system.default}"
    return sorted(scenes, key=lambda scene: (scene.name != default, bool(scene.hard)))


def system_view(study: Study, records: Records, system: SystemRecord, every: Results) -> View:
    """Returns the view of one system: the views of its scenes in `study`, its findings, galleries
    and matrices. `every` holds the results of all methods on all scenes."""
    scenes = in_order(study, system)
    by_scene = {
        scene.name: [of for (where, _), of in every.items() if where == scene.name]
        for scene in scenes
    }
    views = tuple(
        scene_view(study, record, record.exact, by_scene[scene.name])
        for scene in scenes
        if (record := records.scenes[scene.name]).exact and by_scene[scene.name]
    )
    return View(
        system=system,
        about=described(system.name),
        galleries=formed(study, system.name, "gallery"),
        findings=formed(study, system.name),
        scenes=views,  # the one that stands for the system first
        leading=views[0] if views else None,  # the system's page shows its measurements
        matrices=matrix.matrices(study, every, scenes),
        hard=hard_cases.table([of.results for of in views if of.scene.hard]),
    )


def scene_view(
    study: Study, record: SceneRecord, exact: ExactRecord, results: Sequence[MethodResult]
) -> View:
    """Returns the view of one scene of `study`: its figures, tables, sentences and replay.

    `record` holds the scene's verdicts and recommendations, `exact` its exact motion, and `results`
    the result of each method on the scene."""
    scene = results[0].scene
    observables = study.observables(results[0].scene.name)
    rows = [of for of in results if of.judged.verdict != "missing"]
    missing = Counter(of.method.engine for of in results if of not in rows)
    ran = {of.name: of for of in rows if of.done}
    answer = next((answer for answer in record.recommendations if answer.error == WANTED), None)
    at_first = _at_first(answer, ran)
    looks = styles(m.name for m in study.methods)
    units = {o.name: o.unit for o in observables}
    counted = Counter(of.judged.verdict for of in rows)
    tables_below = (
        top_tables.scene_recommendations(record.recommendations),
        table_or_none(
            "orders", rows=[of for of in ran.values() if of.method.order is not None]
        ),
        table_or_none("gradients", records=_derivatives(study, scene.name)),
        trimming(study, scene),
        table_or_none("cost", rows=[of for of in rows if of.cost]),
        table_or_none("budgets", rows=rows, units=units),
        table("every_run", leading=observables[0], rows=rows),
        table(
            "parameters", parameters=scene.parameters, facts=exact.facts, source=scene.source
        ),
    )
    timed = points(study, scene.name)
    typical = (
        reference_run(ran[at_first[-1]].done, ran[at_first[-1]].method) if at_first else None
    )
    return View(
        scene=scene,
        anchor=anchor(scene.name),
        # verdicts, and how many methods have each
        counts=[
            (verdict, counted[verdict]) for verdict in get_args(Verdict) if counted[verdict]
        ],
        # engines that are not installed, with their methods' number
        missing=[f"{engine} ({notation.plural(n, 'method')})" for engine, n in missing.items()],
        methods=tuple(ran),
        at_first=at_first,  # methods whose curves are drawn before a reader chooses others
        sentences=sentences(rows, answer),
        first=table("scene_errors", rows=rows),
        figures=scene_figures(rows, observables, looks, exact.motion, timed, at_first),
        replay=exact.replay,
        hard=hard_cases.table([rows]) if scene.hard or any(of.limit for of in rows) else None,
        results=rows,
        rest=tuple(t for t in tables_below if t),
        typical=typical,  # a run
    )


def sentences(rows: Sequence[MethodResult], answer: Recommendation | None) -> tuple[str, ...]:
    """Returns the sentences at the top of a scene's page: the error of MuJoCo's default settings,
    the recommended method and its cost, and for both whether a smaller step helps."""
    return paragraphs(
        "scene",
        default=DEFAULT_METHOD,
        results={of.name: of for of in rows},
        usable=[of.name for of in rows if of.at_reference and of.method.engine == "mujoco"],
        answer=answer,
    )


def _derivatives(study: Study, scene: str) -> list[Any]:
    """Returns the records of the derivatives of a scene's final state, one per way of
    differentiating."""
    judged = [
        a.numbers["records"] for a in study.analyses if a.template == DERIVATIVES and a.numbers
    ]
    return [of for records in judged for of in records if of["scene"] == scene]


def _at_first(
    answer: Recommendation | None, ran: Mapping[str, MethodResult]
) -> tuple[str, ...]:
    """Returns the names of the methods whose curves are drawn before a reader chooses others.

    These are MuJoCo's default settings and one method of each engine: the recommended one, or, if
    there is none, the method with the smallest error. A closed form has no curve and is left
    out."""
    best: dict[str, str] = {}
    simulated = [of for of in ran.values() if of.method.scheme.integrator != EXACT]
    for of in sorted(
        simulated, key=lambda of: (bool(of.method.surrogate), min(of.errors.values()))
    ):
        best.setdefault(of.method.engine, of.name)
    for choice in answer.by_engine if answer else ():
        best[choice.method.partition("/")[0]] = choice.method
    return tuple(
        name for name in dict.fromkeys((DEFAULT_METHOD, *best.values())) if name in ran
    )
