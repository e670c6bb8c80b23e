"""The page: one self-contained HTML file of a study, readable anywhere, without a network."""

from __future__ import annotations

import json
import os
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plumbob.engines.method import Method
from plumbob.engines.study.results import Study
from plumbob.models.registry import systems
from plumbob.models.scene import Quantity, Scene, System
from plumbob.reports.advice.user_settings import user_results
from plumbob.reports.advice.work_precision import points
from plumbob.reports.judge.verdict import LEAVES_OUT, Judged, Judgements, Verdict, judge_study
from plumbob.reports.view import notation, overview, sensitivity, tables, tightness
from plumbob.reports.view.content import Figure, Finding, Section, Table
from plumbob.reports.view.overview import anchor
from plumbob.reports.view.palette import styles
from plumbob.reports.view.plots import scene_figures
from plumbob.reports.view.settings import pasted
from plumbob.reports.view.trimming import trimming
from plumbob.reports.view.user_settings import table as own_table

NAME = "index.html"
Replays = Callable[[Study, Scene], Any]  # the replay of one scene, as its template takes it
Sections = Callable[[str], Section | None]  # what there is to say of one system alone, by its name
TEMPLATES = Path(__file__).parent / "templates"
ORDER: tuple[Verdict, ...] = (
    "pass", "converges", "fail", "not-converging", "diverged", "pre-asymptotic", "unsupported",
    "missing",
)  # fmt: skip


@dataclass(frozen=True)
class SceneView:
    """One scene as the page shows it: the first table, then figures, then the rest."""

    scene: Scene
    anchor: str
    counts: tuple[tuple[str, int], ...]  # verdicts, and how many methods have each
    methods: tuple[str, ...]  # those that ran
    first: tuple[Table, ...]
    figures: tuple[Figure, ...]
    hard: tuple[Figure | Table, ...]
    rest: tuple[Table, ...]
    replay: Any  # None: the page has none


@dataclass(frozen=True)
class SystemView:
    """One system as the page shows it."""

    system: System
    galleries: tuple[tuple[str, Sequence[Figure]], ...]
    findings: tuple[Finding, ...]
    scenes: tuple[SceneView, ...]


def write_page(
    study: Study,
    folder: Path,
    section: Sections,
    judged: Judgements | None = None,
    replays: Replays | None = None,
) -> Path:
    """Write the page of `study` into `folder`, whole or not at all, and return its path; `section`
    finds what there is to say of one system alone, `judged` are the study's verdicts where they
    are known already, `replays` makes the scenes move. Raises OSError where the folder cannot be
    written."""
    return written(render(study, section, judged, replays), folder, NAME)


def written(text: str, folder: Path, name: str) -> Path:
    """Write a page into `folder` under `name`, whole or not at all, and return its path; raises
    OSError where the folder cannot be written."""
    folder.mkdir(parents=True, exist_ok=True)
    handle, made = tempfile.mkstemp(prefix=".page-", suffix=".html", dir=folder)
    try:
        with open(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(made, 0o644)
        os.replace(made, folder / name)
    except BaseException:
        Path(made).unlink(missing_ok=True)
        raise
    return folder / name


def render(
    study: Study,
    section: Sections,
    judged: Judgements | None = None,
    replays: Replays | None = None,
) -> str:
    """The page of `study` as HTML: a function of the study alone, which runs no engine."""
    found = judge_study(study) if judged is None else judged
    views = [_system(study, system, found, section, replays) for system in systems().values()]
    views = [view for view in views if view.scenes]
    findings = [finding for view in views for finding in view.findings]
    return filled(
        "page.html.jinja",
        study=study,
        views=views,
        findings=findings,
        sources=overview.sources(findings),
        counts=_counts(found.values()),
        user_settings=own_table(user_results(study, found)),
        verdicts=[overview.verdicts(view.system, study, found) for view in views],
        recommendations=overview.recommendations(study, found),
        settings=pasted(study),
        tightness=tightness.tables(study, found),
        styles=styles(study.methods),
        provenance=study.provenance,
        number=notation.number,
    )


def filled(template: str, **content: Any) -> str:
    """A template of a page filled with its content, the style sheet and the scripts as HTML."""
    import jinja2
    from markupsafe import Markup
    from plotly.offline import get_plotlyjs

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["figure_json"] = lambda figure: Markup(figure_json(figure))
    return environment.get_template(template).render(
        **content,
        seconds=notation.seconds,
        style_sheet=Markup(_texts("page.css", "replay.css")),
        script=Markup(_texts("page.js", "replay.js")),
        plotly=Markup(get_plotlyjs()),
    )


def _texts(*names: str) -> str:
    return "\n".join((TEMPLATES / name).read_text("utf-8") for name in names)


def figure_json(figure: Figure) -> str:
    """A figure's traces and layout as JSON that no HTML parser takes for a tag; x and y are places
    in a list of arrays, since many methods share their times and some their errors."""
    arrays: dict[str, int] = {}
    traces = [
        {key: _once(value, arrays) if key in "xy" else value for key, value in trace.items()}
        for trace in figure.traces
    ]
    text = json.dumps(
        {"arrays": [json.loads(a) for a in arrays], "data": traces, "layout": figure.layout},
        ensure_ascii=False, allow_nan=False, separators=(",", ":"),
    )  # fmt: skip
    return text.replace("<", "\\u003c")


def _once(values: Any, arrays: dict[str, int]) -> int:
    """The place of an array among `arrays`, where it stands once."""
    return arrays.setdefault(json.dumps(values, allow_nan=False), len(arrays))


def _system(
    study: Study,
    system: System,
    found: Judgements,
    section: Sections,
    replays: Replays | None,
) -> SystemView:
    scenes = [scene for scene in study.scenes if scene.system == system.name]
    # Findings read any observable: there are none where a run leaves one out.
    whole = all(not found[pair].whole.reason.startswith(LEAVES_OUT) for pair in found
                if pair[0] in {scene.name for scene in scenes})  # fmt: skip
    own = section(system.name) if scenes and whole else None
    methods = {method.name: method for method in study.methods}
    return SystemView(
        system,
        tuple(own.figures(study)) if own else (),
        tuple(own.findings(study)) if own else (),
        tuple(_scene(study, system, scene, methods, found, own, replays) for scene in scenes),
    )


def _scene(
    study: Study,
    system: System,
    scene: Scene,
    methods: dict[str, Method],
    found: Judgements,
    own: Section | None,
    replays: Replays | None,
) -> SceneView:
    convergence = [c for c in study.convergence if c.scene == scene.name]
    judged = {c.method: found[scene.name, c.method] for c in convergence}
    costs = {name: cost for (of, name), cost in study.costs.items() if of == scene.name}
    ran = [c.method for c in convergence if any(m.status == "done" for m in c.measurements)]
    first = (
        tables.summary(system, convergence, judged, methods),
        overview.scene_recommendations(study, scene.name, found),
    )
    rest = (
        tables.orders(convergence, methods),
        tables.cost(convergence, costs, methods),
        trimming(study, scene),
        tables.budgets(system, convergence, judged, methods),
        tables.every_run(system, convergence, judged, methods),
        sensitivity.table(study, scene, found),
        tables.parameters(system, scene),
    )
    in_units = (Quantity(study.leading(scene.name).name, 1.0),)
    figures = scene_figures(
        scene, convergence, methods, styles(study.methods), points(study, scene.name, in_units)
    )
    return SceneView(
        scene,
        anchor(scene.name),
        _counts(judged.values()),
        tuple(ran),
        tuple(t for t in first if t),
        figures,
        tuple(own.hard(study, scene)) if own and scene.hard else (),
        tuple(t for t in rest if t),
        replays(study, scene) if replays else None,
    )


def _counts(judged: Iterable[Judged]) -> tuple[tuple[str, int], ...]:
    """Verdicts, and how many methods have each, in the page's order."""
    counted = Counter(found.whole.verdict for found in judged)
    return tuple((verdict, counted[verdict]) for verdict in ORDER if counted[verdict])
