"""The output of `plumbob validate`: the unexpected first, a table a scene, and the summary last."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from plumbob.engines.study.measurement import reference_run, worst
from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import pairs
from plumbob.models.scene import Scene
from plumbob.reports.judge.expectations import Standing, expected, standing, surprise
from plumbob.reports.judge.searches import judged_searches, unexpected
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.view.content import Table
from plumbob.reports.view.tables import lines, table


def unexpected_lines(study: Study, judged: Judgements) -> list[str]:
    """The unexpected verdicts: scene, method, verdict, what was expected, and why; then those on
    largest steps and derivatives."""
    verdicts = [
        (scene.name, method.name, surprise(scene, method, judgement), judgement.reason, reason)
        for scene, method in pairs(study.scenes, study.methods)
        if standing(scene, method, judgement := judged[scene.name, method.name].whole)
        == "unexpected"
        for reason in (expected(scene.name, method.name).reason,)
    ]
    return lines("unexpected", verdicts=verdicts, searches=unexpected(judged_searches(study)))


def scene_lines(
    scene: Scene, study: Study, judged: Judgements, verbose: bool = False
) -> Iterator[str]:
    """The table of one scene, a row a method: its relative error at the reference step, and what
    that costs; with `verbose` every reason, the confidence interval of every order, and the cost of
    a step too."""
    ran = {c.method: c for c in study.convergence if c.scene == scene.name}
    about, rows = study.quantities(scene.name), []
    for _, method in pairs((scene,), study.methods):
        result, done = judged[scene.name, method.name].whole, ran[method.name]
        run = reference_run(done.measurements, method)
        error, cost = run and worst(run, about), study.costs.get((scene.name, method.name))
        rows.append((method, result, standing(scene, method, result), done.order, run, error, cost))
    if not rows:
        return
    written = table("scene", rows=rows, about=about, verbose=verbose, infinity=math.inf)
    heads, *cells = aligned(written)
    yield f"{scene.name}: {scene.summary}" if verbose else scene.name
    yield f"  {heads}"
    for (_, result, *_), line in zip(rows, cells, strict=True):
        yield f"  {line}"
        if verbose:
            yield from (f"      {reason}" for reason in (result.reason,) if reason)
            yield from (f"      not judged: {n}, {why}" for n, why in result.unjudged.items())


def summary_lines(study: Study, judged: Judgements, page: Path) -> list[str]:
    """The last lines: runs, verdicts, known limits, unexpected verdicts, and where the page is."""
    means: Counter[Standing] = Counter()
    verdicts: Counter[str] = Counter()
    for scene, method in pairs(study.scenes, study.methods):
        judgement = judged[scene.name, method.name].whole
        means[standing(scene, method, judgement)] += 1
        verdicts[judgement.verdict] += 1
    for of in judged_searches(study):
        means["unexpected"] += bool(of.surprise)
        means["known limit"] += bool(of.known and not of.surprise)
    return lines(
        "summary",
        runs=sum(
            m.status in ("done", "diverged") for c in study.convergence for m in c.measurements
        ),
        verdicts=verdicts,
        known=means["known limit"],
        unexpected=means["unexpected"],
        page=page,
    )


def aligned(table: Table) -> Iterator[str]:
    """A table as lines whose columns are below one another."""
    rows = [table.heads, *([cell.text for cell in row] for row in table.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for cells in rows:
        yield "  ".join(map(str.ljust, cells, widths)).rstrip()
