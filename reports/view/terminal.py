"""Values of the output of `plumbob validate`: unexpected verdicts first, then a table for each
scene, and the summary last."""

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


def study_values(study: Study, all_results: Results, verbose: bool) -> dict[str, Any]:
    """Returns the values of the template that writes a study to the terminal.

    They are the unexpected verdicts, on methods as well as on largest steps and derivatives; for
    each scene, its lines, one per method with its relative error at the reference step and its
    cost; and counts of verdicts. With `verbose`, a line also has each interval of the order and the
    cost of a step."""
    searches = judged_searches(study)
    scenes = []
    for scene in study.scenes:
        rows = [result for (name, _), result in all_results.items() if name == scene.name]
        if rows:
            about = rows[0].quantities
            lines = table("scene", rows=rows, about=about, verbose=verbose, infinity=math.inf)
            # the first line holds the heads, so no result belongs to it
            scenes.append((scene, list(zip((None, *rows), aligned(lines), strict=True))))
    results = all_results.values()
    standings = Counter(result.judged.standing for result in results)
    known = sum(bool(search.known and not search.surprise) for search in searches)
    surprising = sum(bool(search.surprise) for search in searches)
    return {
        "surprises": [result for result in results if result.judged.mark == "unexpected"],
        "searches": unexpected_searches(searches),
        "scenes": scenes,
        "verbose": verbose,
        "runs": sum(len(result.errors) for result in results),
        "verdicts": Counter(result.judged.verdict for result in results),
        "known": standings["known limit"] + known,
        "known_searches": known,
        "meanings": Counter(result.meaning for result in results),
        "unexpected": standings["unexpected"] + surprising,
    }


def aligned(table: Table) -> Iterator[str]:
    """Yields the lines of a table with aligned columns."""
    rows = [table.heads, *([cell.text for cell in row] for row in table.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for cells in rows:
        yield "  ".join(map(str.ljust, cells, widths)).rstrip()
