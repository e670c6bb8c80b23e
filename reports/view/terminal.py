"""The output of `plumbob validate`: the unexpected first, a table a scene, and the summary last."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from typing import Any

from plumbob.engines.study.results import Study
from plumbob.reports.judge.searches import judged_searches, unexpected_searches
from plumbob.reports.view.content import Table
from plumbob.reports.view.method_results import Results
from plumbob.reports.view.tables import table


def study_values(study: Study, every: Results, verbose: bool) -> dict[str, Any]:
    """Numbers in the lines of a study: unexpected verdicts, with those on largest steps and
    derivatives; of each scene a line a method, its relative error at the reference step and
    what that costs, and with `verbose` every interval of an order and the cost of a step too; and
    counts."""
    searches = judged_searches(study)
    scenes = []
    for scene in study.scenes:
        rows = [of for (name, _), of in every.items() if name == scene.name]
        if rows:
            about = rows[0].quantities
            shown = table("scene", rows=rows, about=about, verbose=verbose, infinity=math.inf)
            scenes.append((scene, list(zip((None, *rows), aligned(shown), strict=True))))
    standings = Counter(of.judged.standing for of in every.values())
    known = sum(bool(of.known and not of.surprise) for of in searches)
    return {
        "surprises": [of for of in every.values() if of.judged.mark == "unexpected"],
        "searches": unexpected_searches(searches),
        "scenes": scenes,
        "verbose": verbose,
        "runs": sum(len(of.errors) for of in every.values()),
        "verdicts": Counter(of.judged.verdict for of in every.values()),
        "known": standings["known limit"] + known,
        "known_searches": known,
        "meanings": Counter(of.meaning for of in every.values()),
        "unexpected": standings["unexpected"] + sum(bool(of.surprise) for of in searches),
    }


def aligned(table: Table) -> Iterator[str]:
    """A table as lines whose columns are below one another."""
    rows = [table.heads, *([cell.text for cell in row] for row in table.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for cells in rows:
        yield "  ".join(map(str.ljust, cells, widths)).rstrip()
