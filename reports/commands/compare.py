"""plumbob compare: what has changed between two studies."""

from __future__ import annotations

import argparse
import math
import os
from itertools import chain
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store
from plumbob.engines.study.results import Study
from plumbob.reports.columns.columns import columns_of
from plumbob.reports.commands.arguments import values
from plumbob.reports.judge.study_differences import study_differences


def command(chosen: argparse.Namespace) -> int:
    """Prints what differs between two studies. Returns 1 if a verdict differs, or if an error grew
    by more than the user allows."""
    old = _read_study("OLD", chosen.old)
    new = _read_study("NEW", chosen.new)
    moved = study_differences(old, new)
    versions = moved.pop("versions")
    rows = list(chain.from_iterable(moved.values()))
    above = math.inf if chosen.above is None else chosen.above
    growths = [row["growth"] for row in rows if row["growth"] is not None]
    grown = sum(growth > above for growth in growths)
    growth = {"above": chosen.above, "grown": grown}
    page: Path | None = None
    if chosen.page:
        from plumbob.reports.view.site.comparison import write_comparison

        studies = [(chosen.old, old), (chosen.new, new)]
        page = write_comparison(chosen.page, studies, moved, chosen.line, **growth)
    values.show(
        chosen,
        [*versions, *rows],
        "compare",
        columns=lambda: columns_of("changes", [*versions, *rows]),
        made={"old": old.provenance, "new": new.provenance},
        moved=rows,
        versions=versions,
        verdicts=moved["verdicts"],
        page=page,
        **growth,
    )
    return 1 if moved["verdicts"] or grown else 0


def _read_study(name: str, text: str) -> Study:
    """Returns the study in a file or folder; `text` is its path, or PATH#N for study number N.
    Raises ParameterError for the argument `name`."""
    path, number = text, None
    if "#" in text and not os.path.lexists(text):
        path, _, digits = text.rpartition("#")
        number = values.count(f"the number of the study in {name}", digits)
    place = Path(path)
    study = store.load(place / store.FILE if place.is_dir() else place, number)
    if study is None:
        raise ParameterError(name, text, "where `plumbob validate` has stored a study")
    return study
