"""plumbob validate: the main job: measure scenes with methods, judge, and write the page."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from plumbob.engines.method import USER_METHOD, Method
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study import store
from plumbob.engines.study.checkpoint import measured_into
from plumbob.engines.study.convergence import SEED
from plumbob.engines.study.results import Analysed, Study
from plumbob.engines.study.runner import pairs, run_study
from plumbob.engines.workers import Workers
from plumbob.models.registry import scenes as find_scenes
from plumbob.models.scene import Scene
from plumbob.reports.advice.json_records import study_records
from plumbob.reports.advice.user_settings import user_results
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.arguments.console import note, progress, writable_folder
from plumbob.reports.commands.arguments.like import METHODS as LIKE_METHODS
from plumbob.reports.commands.arguments.like import SCENES as LIKE_SCENES
from plumbob.reports.commands.arguments.like import beside, own_method
from plumbob.reports.judge.searches import judged_searches, unexpected_searches
from plumbob.reports.judge.study_verdicts import Judgements, judge_study
from plumbob.reports.view.junit import write_junit
from plumbob.reports.view.method_results import Results, results_of
from plumbob.reports.view.own_files import check_replaceable
from plumbob.reports.view.records import records_of

if TYPE_CHECKING:
    from concurrent.futures import Executor

INCOMPLETE = 3
Pair = tuple[str, str]  # scene, method


def command(chosen: argparse.Namespace) -> int:
    """Run the study, print the verdicts, write the page."""
    scenes = find_scenes(chosen.scenes or (LIKE_SCENES if chosen.like else "*"), chosen.profile)
    methods = _methods(chosen.methods, chosen.like)
    if chosen.like:
        scenes = tuple(beside(scene, methods[0]) for scene in scenes)
    if not pairs(scenes, methods):
        note(_reason_of_no_runs(scenes, methods))
    with values.workers(chosen) as (executor, jobs):
        return _validated(chosen, scenes, methods, executor, jobs)


def _validated(
    chosen: argparse.Namespace,
    scenes: Sequence[Scene],
    methods: Sequence[Method],
    executor: Executor | None,
    jobs: int,
) -> int:
    """Measure these scenes with these methods, the errors on the executor or in so many processes,
    and report; returns the exit code."""
    from plumbob.reports.analyses import analyses_of, requests
    from plumbob.reports.analyses.engines.gradients import with_each_pair
    from plumbob.reports.view.site.writing import check_site_replaceable

    judged: list[Judgements] = []  # once, for the analyses and for what is printed

    def analyse(study: Study, workers: Workers) -> tuple[Analysed, ...]:
        judged.append(judge_study(study, chosen.within))
        return analyses_of(study, workers, judged[0])

    junit = check_replaceable("junitxml", Path(chosen.junitxml)) if chosen.junitxml else None
    check_site_replaceable("out", Path(chosen.out))
    out = writable_folder("out", Path(chosen.out))
    if junit:
        writable_folder("junitxml", junit.parent)
    with Workers(jobs) as workers:
        with measured_into(out / store.FILE, chosen.fresh, note) as kept, progress() as show:
            try:
                run_study(
                    scenes,
                    methods,
                    chosen.profile,
                    workers,
                    executor,
                    progress=show,
                    requests=with_each_pair(requests) if chosen.gradients else requests,
                    command=chosen.line,
                    kept=kept,
                    seed=chosen.seed or SEED,
                    analyse=analyse,
                )
            except BaseException as error:
                error.add_note(
                    "what is measured is stored: the same command goes on from there"
                )
                raise
        for what in kept.given_up:
            note(f"given up: {what}; the same command tries it again")
        try:
            code = _report(chosen, out, kept.number, junit, judged[0])
            return code or (INCOMPLETE if kept.given_up else 0)
        except BaseException as error:
            drawn = shlex.join(["plumbob", "report", str(out), "--study", str(kept.number)])
            error.add_note(f"the study is stored: `{drawn}` draws its page")
            raise


def _report(
    chosen: argparse.Namespace,
    out: Path,
    number: int,
    junit: Path | None,
    judged: Judgements,
) -> int:
    """Write the pages of the stored study of that number, as `plumbob report` does, and what else
    was asked for; returns the exit code."""
    from plumbob.reports.view.site.writing import write_page
    from plumbob.reports.view.terminal import study_values
    from plumbob.reports.view.user_settings import cost_factor

    study = store.load(out / store.FILE, number)
    assert study
    results = user_results(study, judged)
    page = write_page(study, out)
    every = results_of(study, records_of(study))
    if junit:
        write_junit(junit, study, every)
    values.show(
        chosen,
        study_records(study, judged, results),
        "study",
        **study_values(study, every, chosen.verbose),
        page=page,
        results=results,
        like=chosen.like,
        factor=cost_factor,
    )
    return exit_code(study, every)


def _methods(pattern: str | None, like: str | None) -> tuple[Method, ...]:
    """The methods that were asked for, the user's own among them."""
    methods = find_methods(pattern or (LIKE_METHODS if like else "*"))
    if pattern in (None, "*"):
        methods = tuple(
            m for m in methods if installed(engine_of(m)) or not engine_of(m).optional
        )
    return (own_method(like), *methods) if like else methods


def _reason_of_no_runs(scenes: Sequence[Scene], methods: Sequence[Method]) -> str:
    """One line that says why a study of these scenes and methods has no runs."""
    patterns = ",".join(f"{engine}/*" for engine in dict.fromkeys(m.engine for m in methods))
    others = dict.fromkeys(method.name for _, method in pairs(scenes, find_methods(patterns)))
    names = ", ".join(method.name for method in methods)
    meant = f"; meant for them: {', '.join(others)}" if others else ""
    return f"no runs: none of the methods {names} is meant for one of these scenes{meant}"


def exit_code(study: Study, every: Results) -> int:
    """1 when a verdict is not as expected, else 3 when an engine is missing or the user's own
    settings ran nothing, else 0."""
    if unexpected_searches(judged_searches(study)) or "unexpected" in {
        of.meaning for of in every.values()
    }:
        return 1
    verdicts = {of.judged.verdict for of in every.values()}
    user = {of.judged.verdict for of in every.values() if of.name == USER_METHOD}
    nothing = user and user <= {"unsupported", "missing"}
    return INCOMPLETE if nothing or "missing" in verdicts else 0
