"""Values of the output of `plumbob validate`: unexpected verdicts first, then a table for each
scene, and the summary last."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from typing import Any

from plumbob.engines.study.results import Study
from plumbob.reports.judge.searches import judged_searches, unexpected
from plumbob.reports.view.content import Table
from plumbob.reports.view.method_results import Results
from plumbob.reports.view.tables import table


def study_values(study: Study, every: Results, verbose: bool) -> dict[str, Any]:
    """Returns the values of the template that writes a study to the terminal.

    They are the unexpected verdicts, on methods as well as on largest steps and derivatives; for
    each scene, its lines, one per method with its relative error at the reference step and its
    cost; and counts of verdicts. With `verbose`, a line also has each interval of the order and the
    cost of a step."""
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
        "searches": unexpected(searches),
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
    """Yields the lines of a table with aligned columns."""
    rows = [table.heads, *([cell.text for cell in row] for row in table.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for cells in rows:
        yield "  ".join(map(str.ljust, cells, widths)).rstrip()
