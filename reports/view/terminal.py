"""The output of `plumbob validate`: the unexpected first, a table a scene, and the summary last."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.judge.searches import judged_searches, unexpected
from plumbob.reports.view.content import Table
from plumbob.reports.view.method_results import Results
from plumbob.reports.view.tables import lines, table


def unexpected_lines(study: Study, every: Results) -> list[str]:
    """The unexpected verdicts: scene, method, verdict, what was expected, and why; then those on
    largest steps and derivatives."""
    verdicts = [of for of in every.values() if of.judged.mark == "unexpected"]
    return lines("unexpected", verdicts=verdicts, searches=unexpected(judged_searches(study)))


def scene_lines(scene: Scene, every: Results, verbose: bool = False) -> Iterator[str]:
    """The table of one scene, a row a method: its relative error at the reference step, and what
    that costs; with `verbose` every reason, the confidence interval of every order, and the cost of
    a step too."""
    rows = [of for (name, _), of in every.items() if name == scene.name]
    if not rows:
        return
    about = rows[0].quantities
    heads, *cells = aligned(
        table("scene", rows=rows, about=about, verbose=verbose, infinity=math.inf)
    )
    yield f"{scene.name}: {scene.summary}" if verbose else scene.name
    yield f"  {heads}"
    for of, line in zip(rows, cells, strict=True):
        yield f"  {line}"
        if verbose:
            yield from (f"      {reason}" for reason in (of.judged.reason,) if reason)
            yield from (f"      not judged: {n}, {why}" for n, why in of.judged.unjudged.items())


def summary_lines(study: Study, every: Results, page: Path) -> list[str]:
    """The last lines: runs, verdicts, known limits, unexpected verdicts, and where the page is."""
    standings = Counter(of.judged.standing for of in every.values())
    searches = judged_searches(study)
    return lines(
        "summary",
        runs=sum(len(of.errors) for of in every.values()),
        verdicts=Counter(of.judged.verdict for of in every.values()),
        known=standings["known limit"] + sum(bool(of.known and not of.surprise) for of in searches),
        unexpected=standings["unexpected"] + sum(bool(of.surprise) for of in searches),
        page=page,
    )


def aligned(table: Table) -> Iterator[str]:
    """A table as lines whose columns are below one another."""
    rows = [table.heads, *([cell.text for cell in row] for row in table.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for cells in rows:
        yield "  ".join(map(str.ljust, cells, widths)).rstrip()
