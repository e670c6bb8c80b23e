"""plumbob stability: the largest step at which methods hold on scenes, or with --long the time
after which they are wrong, beside its prediction."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.long_runs import LongRunSearch, MeasuredLongRun
from plumbob.engines.study.stability import StabilitySearch
from plumbob.reports.commands.arguments import values
from plumbob.reports.judge.long_runs import JudgedLongRun, judged_long_run
from plumbob.reports.judge.stability import JudgedLimit, study_limits
from plumbob.reports.view.own_files import replaceable
from plumbob.reports.view.stability import NAME, table, write_page
from plumbob.reports.view.terminal import aligned

if TYPE_CHECKING:
    from plumbob.engines.method import Method
    from plumbob.engines.study.request import RunRequest
    from plumbob.engines.study.results import Study
    from plumbob.models.scene import Scene

INCOMPLETE = 3
FILE = "stability.sqlite3"


def command(chosen: argparse.Namespace) -> int:
    """Measure, print and judge the largest steps; 1 where one is not as expected."""
    scenes = values.scenes(chosen.scene, {})
    methods = find_methods(",".join(chosen.method) or "*")
    if chosen.out:
        replaceable("out", Path(chosen.out) / NAME)
    if not chosen.method:
        methods = tuple(m for m in methods if installed(engine_of(m)))
    study = _measured(chosen, scenes, methods)
    judged = list(_judged(study))
    page = chosen.out and write_page(judged, study.provenance, Path(chosen.out))
    records = [of.record() for of in judged]
    shown = aligned(table(judged))
    surprises = [
        (record, of) for record, of in zip(records, judged, strict=True) if of.surprise
    ]
    values.show(chosen, records, "stability", rows=shown, surprises=surprises, page=page)
    if surprises:
        return 1
    return 0 if all(installed(engine_of(m)) for m in methods) else INCOMPLETE


def _measured(
    chosen: argparse.Namespace, scenes: Sequence[Scene], methods: Sequence[Method]
) -> Study:
    """A study of these searches, and of nothing else, kept where a folder is given."""
    from plumbob.engines.study.runner import pairs

    if chosen.step is not None and not chosen.long:
        raise ParameterError("step", chosen.step, "left out without --long")
    searches = [
        LongRunSearch(s.name, m.name, chosen.step)
        if chosen.long
        else StabilitySearch(s.name, m.name)
        for s, m in pairs(scenes, methods)
    ]
    if not searches:
        given = ",".join(chosen.method) or None
        raise ParameterError("method", given, f"one that is meant for {chosen.scene}")
    return measured(chosen, methods, searches, chosen.out)


def measured(
    chosen: argparse.Namespace,
    methods: Sequence[Method],
    searches: Sequence[RunRequest[Any]],
    out: str | None = None,
) -> Study:
    """A study of these searches, and of nothing else, kept in the folder `out`; raises
    ParameterError."""
    from plumbob.engines.study.checkpoint import measured_into
    from plumbob.engines.study.runner import run_study
    from plumbob.reports.commands.validate import noted, progress, writable

    jobs = min(chosen.jobs or os.cpu_count() or 1, len(searches))
    file = writable("out", Path(out)) / FILE if out else None
    with measured_into(file, note=noted) as kept, progress() as show:
        return run_study(
            (),
            methods,
            jobs=jobs,
            progress=show,
            timed=False,
            requests=lambda plan: searches,
            command=chosen.line,
            kept=kept,
        )


def _judged(study: Study) -> Iterator[JudgedLimit | JudgedLongRun]:
    """The long runs and the limits that a study holds; of one whose engine is missing, or whose
    process was lost, why there is none."""
    for request in study.extras:
        if isinstance(request, LongRunSearch):
            why = "its engine is missing, or its process was lost"
            yield judged_long_run(request, study.answer(request) or MeasuredLongRun(why=why))
    yield from study_limits(study)
