"""plumbob validate: measure scenes with methods, judge the errors, and write the pages."""

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
from plumbob.engines.study.repeating import RepeatedPair, repeated_pairs
from plumbob.engines.study.results import Analysed, Study
from plumbob.engines.study.runner import pairs, run_study
from plumbob.engines.workers import Workers
from plumbob.models.registry import matching_scenes as find_scenes
from plumbob.models.scene import Scene
from plumbob.reports.advice.json_records import study_records
from plumbob.reports.advice.user_settings import user_results
from plumbob.reports.columns.study_columns import StudyColumns
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.arguments.console import note, progress, writable_folder
from plumbob.reports.commands.arguments.like import METHODS as LIKE_METHODS
from plumbob.reports.commands.arguments.like import SCENES as LIKE_SCENES
from plumbob.reports.commands.arguments.like import beside, own_method
from plumbob.reports.judge.searches import judged_searches, unexpected_searches
from plumbob.reports.judge.study_verdicts import Judgements, judge_study
from plumbob.reports.records.page_records import records_of
from plumbob.reports.view.junit import write_study_junit
from plumbob.reports.view.method_results import Results, results_of
from plumbob.reports.view.own_files import check_replaceable

if TYPE_CHECKING:
    from concurrent.futures import Executor

INCOMPLETE = 3
OTHER_BITS = 1  # exit code: a pair has other bits when it is repeated


def command(chosen: argparse.Namespace) -> int:
    """Measures the scenes with the methods, prints the verdicts and writes the pages."""
    scenes = find_scenes(chosen.scenes or (LIKE_SCENES if chosen.like else "*"), chosen.profile)
    methods = _methods(chosen.methods, chosen.like)
    if chosen.like:
        scenes = tuple(beside(scene, methods[0]) for scene in scenes)
    if not pairs(scenes, methods):
        note(_reason_of_no_runs(scenes, methods))
    with values.workers(chosen) as (executor, jobs):
        return _measure_and_report(chosen, scenes, methods, executor, jobs)


def _measure_and_report(
    chosen: argparse.Namespace,
    scenes: Sequence[Scene],
    methods: Sequence[Method],
    executor: Executor | None,
    jobs: int,
) -> int:
    """Measures the scenes with the methods, prints the verdicts and writes the pages. Errors are
    measured by the `executor` if there is one, else in `jobs` processes. Returns the exit code."""
    from plumbob.reports.analyses import analyses_of, requests
    from plumbob.reports.analyses.engines.gradients import with_each_pair
    from plumbob.reports.view.site.writing import check_site_replaceable

    judged: list[Judgements] = []  # one element, for the analyses and the terminal

    def analyse(study: Study, workers: Workers) -> tuple[Analysed, ...]:
        judged.append(judge_study(study, chosen.within))
        return analyses_of(study, workers, judged[0])

    junit = check_replaceable("junitxml", Path(chosen.junitxml)) if chosen.junitxml else None
    check_site_replaceable("out", Path(chosen.out))
    out = writable_folder("out", Path(chosen.out))
    if junit:
        writable_folder("junitxml", junit.parent)
    with Workers(jobs) as workers:
        with (
            measured_into(out / store.FILE, chosen.fresh, note) as checkpoint,
            progress() as show,
        ):
            try:
                study = run_study(
                    scenes,
                    methods,
                    chosen.profile,
                    workers,
                    executor,
                    progress=show,
                    requests=with_each_pair(requests) if chosen.gradients else requests,
                    command=chosen.line,
                    kept=checkpoint,
                    seed=chosen.seed or SEED,
                    analyse=analyse,
                )
            except BaseException as error:
                error.add_note(
                    "what is measured is stored: the same command goes on from there"
                )
                raise
            repeated = repeated_pairs(study, show) if chosen.repeat else ()
        for task in checkpoint.given_up:
            note(f"given up: {task}; the same command tries it again")
        number = checkpoint.number
        try:
            code = _print_and_write(chosen, out, study, junit, judged[0], repeated)
            return code or (INCOMPLETE if checkpoint.given_up else 0)
        except BaseException as error:
            report = shlex.join(["plumbob", "report", str(out), "--study", str(number)])
            error.add_note(f"the study is stored: `{report}` draws its page")
            raise


def _print_and_write(
    chosen: argparse.Namespace,
    out: Path,
    study: Study,
    junit: Path | None,
    judged: Judgements,
    repeated: Sequence[RepeatedPair],
) -> int:
    """Writes the pages of the study and the JUnit file if there is one, and prints the verdicts and
    the pairs that were `repeated`. Returns the exit code."""
    from plumbob.reports.view.site.writing import write_study_pages
    from plumbob.reports.view.terminal import study_values
    from plumbob.reports.view.user_settings import cost_factor

    user_rows = user_results(study, judged)
    page = write_study_pages(study, out)
    results = results_of(study, records_of(study))
    if junit:
        write_study_junit(junit, study, results)
    tables = StudyColumns(study, judged)
    values.show(
        chosen,
        study_records(study, judged, user_rows, repeated),
        "study",
        columns=lambda: tables.errors if chosen.csv else tables.pairs,
        **study_values(study, results, chosen.verbose),
        page=page,
        results=user_rows,
        like=chosen.like,
        factor=cost_factor,
        repeated=repeated,
    )
    other_bits = any(pair.unexpected for pair in repeated)
    return OTHER_BITS if other_bits else exit_code(study, results)


def _methods(pattern: str | None, like: str | None) -> tuple[Method, ...]:
    """Returns the chosen methods; the method of the user's file comes first."""
    methods = find_methods(pattern or (LIKE_METHODS if like else "*"))
    if pattern in (None, "*"):
        # An optional engine that is not installed is not asked for by `*`.
        methods = tuple(
            method
            for method in methods
            if installed(engine_of(method)) or not engine_of(method).optional
        )
    return (own_method(like), *methods) if like else methods


def _reason_of_no_runs(scenes: Sequence[Scene], methods: Sequence[Method]) -> str:
    """Returns one line that says why a study of these scenes and methods has no runs."""
    engines = dict.fromkeys(method.engine for method in methods)
    methods_of_engines = find_methods(",".join(f"{engine}/*" for engine in engines))
    others = dict.fromkeys(method.name for _, method in pairs(scenes, methods_of_engines))
    names = ", ".join(method.name for method in methods)
    advice = f"; meant for them: {', '.join(others)}" if others else ""
    return f"no runs: none of the methods {names} is meant for one of these scenes{advice}"


def exit_code(study: Study, results: Results) -> int:
    """Returns 1 if a verdict is not as expected; else 3 if an engine is missing or the user's own
    settings ran nothing; else 0."""
    meanings = {result.meaning for result in results.values()}
    if unexpected_searches(judged_searches(study)) or "unexpected" in meanings:
        return 1
    verdicts = {result.judged.verdict for result in results.values()}
    user_verdicts = {
        result.judged.verdict for result in results.values() if result.name == USER_METHOD
    }
    user_ran_nothing = user_verdicts and user_verdicts <= {"unsupported", "missing"}
    return INCOMPLETE if user_ran_nothing or "missing" in verdicts else 0
