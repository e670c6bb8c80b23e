"""Views: the values that the templates of scene pages and of system pages read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any, get_args

from plumbob.engines.study.measurement import reference_run
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import (
    CLOSED_FORM_INTEGRATOR,
    DEFAULT_METHOD,
    Recommendation,
)
from plumbob.reports.advice.work_precision import work_precision_points
from plumbob.reports.judge.verdict import Verdict
from plumbob.reports.records import notation
from plumbob.reports.records.page_records import (
    ExactRecord,
    Records,
    ReplayView,
    SceneRecord,
    SystemRecord,
)
from plumbob.reports.view import hard_cases, top_tables
from plumbob.reports.view.about import read_description
from plumbob.reports.view.content import Table
from plumbob.reports.view.method_results import MethodResult, Results
from plumbob.reports.view.palette import styles
from plumbob.reports.view.plots import scene_figures
from plumbob.reports.view.site import matrix
from plumbob.reports.view.site.claims import findings_about
from plumbob.reports.view.site.system_cards import system_card
from plumbob.reports.view.tables import paragraphs, table, table_or_none
from plumbob.reports.view.top_tables import anchor
from plumbob.reports.view.trimming import trimming_table
from plumbob.reports.view.units import parameter_units

PageView = SimpleNamespace
"""The content of a scene's or a system's page; its attributes are the names in the template."""
RECOMMENDED_ERROR = 1e-3  # relative error for which a scene's page recommends a method
# template of the analysis with the derivatives of every scene
DERIVATIVES_TEMPLATE = "engines/gradients"


def scenes_of_system(study: Study, system: SystemRecord) -> list[Scene]:
    """Returns the scenes of `system` in `study`: its default scene first, hard scenes last."""
    scenes = [scene for scene in study.scenes if scene.system == system.name]
    default = f"{system.name}/{system.default}"
    return sorted(scenes, key=lambda scene: (scene.name != default, bool(scene.hard)))


def system_view(
    study: Study, records: Records, system: SystemRecord, all_results: Results
) -> PageView:
    """Returns the view of one system: the views of its scenes in `study`, its findings, galleries
    and matrices. `all_results` holds the results of all methods on all scenes."""
    scenes = scenes_of_system(study, system)
    views = list[PageView]()
    for scene in scenes:
        record = records.scenes[scene.name]
        results = [result for (name, _), result in all_results.items() if name == scene.name]
        if record.exact and results:
            views.append(scene_view(study, record, record.exact, results))
    return PageView(
        system=system,
        about=read_description(system.name),
        galleries=findings_about(study, system.name, "gallery"),
        findings=findings_about(study, system.name),
        scenes=tuple(views),  # the default scene first
        leading=views[0] if views else None,  # the system's page shows its measurements
        card=system_card(views[0].results, views[0].replay) if views else None,
        matrices=matrix.matrices(study, all_results, scenes),
        hard=hard_cases.hard_case_table([view.results for view in views if view.scene.hard]),
    )


def scene_view(
    study: Study, record: SceneRecord, exact: ExactRecord, results: Sequence[MethodResult]
) -> PageView:
    """Returns the view of one scene of `study`: its figures, tables, sentences and replay.

    `record` holds the scene's verdicts and recommendations, `exact` its exact motion, and `results`
    the result of each method on the scene."""
    scene = results[0].scene
    observables = study.observables(results[0].scene.name)
    rows = [result for result in results if result.judged.verdict != "missing"]
    missing = Counter(result.method.engine for result in results if result not in rows)
    ran = {result.name: result for result in rows if result.done}
    answer = next(
        (answer for answer in record.recommendations if answer.error == RECOMMENDED_ERROR), None
    )
    at_first = _methods_at_first(answer, ran)
    method_styles = styles(method.name for method in study.methods)
    verdict_counts = Counter(result.judged.verdict for result in rows)
    timed = work_precision_points(study, scene.name)
    typical = None
    if at_first:
        last = ran[at_first[-1]]
        typical = reference_run(last.done, last.method)
    return PageView(
        scene=scene,
        anchor=anchor(scene.name),
        # verdicts, and how many methods have each
        counts=[
            (verdict, verdict_counts[verdict])
            for verdict in get_args(Verdict)
            if verdict_counts[verdict]
        ],
        # engines that are not installed, with their methods' number
        missing=[f"{engine} ({notation.plural(n, 'method')})" for engine, n in missing.items()],
        methods=tuple(ran),
        at_first=at_first,  # methods whose curves are drawn before a reader chooses others
        sentences=scene_sentences(rows, answer),
        first=table("scene_errors", rows=rows),
        figures=scene_figures(rows, observables, method_styles, exact.motion, timed, at_first),
        # An older study may have a replay of another kind, which no script draws any more.
        replay=exact.replay
        if exact.replay and exact.replay.kind in get_args(ReplayView)
        else None,
        hard=hard_cases.hard_case_table([rows])
        if scene.hard or any(r.limit for r in rows)
        else None,
        results=rows,
        rest=_further_tables(study, scene, record, exact, rows),
        typical=typical,  # run of a recommended method near the reference step
    )


def _further_tables(
    study: Study,
    scene: Scene,
    record: SceneRecord,
    exact: ExactRecord,
    rows: Sequence[MethodResult],
) -> tuple[Table, ...]:
    """Returns the tables below the figures of a scene's page; a table without rows is left out.
    `rows` are the results of the methods whose engines are installed."""
    observables = study.observables(scene.name)
    with_order = [result for result in rows if result.done and result.method.order is not None]
    timed = [result for result in rows if result.cost]
    units = {observable.name: observable.unit for observable in observables}
    parameters = {
        "parameters": scene.parameters,
        "facts": exact.facts,
        "source": scene.source,
        "units": parameter_units(),
    }
    tables = (
        top_tables.scene_recommendations(record.recommendations),
        table_or_none("orders", rows=with_order),
        table_or_none("gradients", records=_derivatives(study, scene.name)),
        trimming_table(study, scene),
        table_or_none("cost", rows=timed),
        table_or_none("budgets", rows=rows, units=units),
        table("every_run", leading=observables[0], rows=rows),
        table("parameters", **parameters),
    )
    return tuple(written for written in tables if written)


def scene_sentences(
    rows: Sequence[MethodResult], answer: Recommendation | None
) -> tuple[str, ...]:
    """Returns the sentences at the top of a scene's page: the error of MuJoCo's default settings,
    the recommended method and its cost, and for both whether a smaller step helps."""
    return paragraphs(
        "scene",
        default=DEFAULT_METHOD,
        results={result.name: result for result in rows},
        usable=[r.name for r in rows if r.at_reference and r.method.engine == "mujoco"],
        answer=answer,
    )


def _derivatives(study: Study, scene: str) -> list[Any]:
    """Returns the records of the derivatives of a scene's final state, one per way of
    differentiating."""
    derivatives = list[Any]()
    for analysis in study.analyses:
        if analysis.template == DERIVATIVES_TEMPLATE and analysis.numbers:
            records = analysis.numbers["records"]
            derivatives += [record for record in records if record["scene"] == scene]
    return derivatives


def _methods_at_first(
    answer: Recommendation | None, ran: Mapping[str, MethodResult]
) -> tuple[str, ...]:
    """Returns the names of the methods whose curves are drawn before a reader chooses others.

    These are MuJoCo's default settings and one method of each engine: the recommended one, or, if
    there is none, the method with the smallest error. A closed form has no curve and is left
    out."""
    best: dict[str, str] = {}  # method by engine
    simulated = [
        r for r in ran.values() if r.method.scheme.integrator != CLOSED_FORM_INTEGRATOR
    ]
    simulated.sort(key=lambda r: (bool(r.method.surrogate), min(r.errors.values())))
    for result in simulated:
        best.setdefault(result.method.engine, result.name)
    if answer:
        best |= {choice.method.partition("/")[0]: choice.method for choice in answer.by_engine}
    names = dict.fromkeys((DEFAULT_METHOD, *best.values()))
    return tuple(name for name in names if name in ran)
