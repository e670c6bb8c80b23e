"""Answer of a command that measures or merges a study: analyses, verdicts, pages and exit code."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from plumbob.engines.method import USER_METHOD
from plumbob.engines.study.repeating import RepeatedPair
from plumbob.engines.study.results import Analysed, Study
from plumbob.engines.study.runner import Analyse
from plumbob.engines.study.scheduler import Progress
from plumbob.engines.workers import Workers
from plumbob.reports.advice.json_records import study_records
from plumbob.reports.advice.user_settings import user_results
from plumbob.reports.columns.study_columns import StudyColumns
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.arguments.console import writable_folder
from plumbob.reports.judge.searches import judged_searches, unexpected_searches
from plumbob.reports.judge.study_verdicts import Judgements, judge_study
from plumbob.reports.records.page_records import records_of
from plumbob.reports.view.junit import write_study_junit
from plumbob.reports.view.method_results import Results, results_of
from plumbob.reports.view.own_files import check_replaceable

INCOMPLETE = 3
OTHER_BITS = 1


def study_targets(chosen: argparse.Namespace) -> tuple[Path, Path | None]:
    """Returns the folder of the pages and the JUnit file, None if the user asks for none. Raises
    ParameterError if one of them cannot be written."""
    from plumbob.reports.view.site.writing import check_site_replaceable

    junit = check_replaceable("junitxml", Path(chosen.junitxml)) if chosen.junitxml else None
    check_site_replaceable("out", Path(chosen.out))
    out = writable_folder("out", Path(chosen.out))
    if junit:
        writable_folder("junitxml", junit.parent)
    return out, junit


def analyse_into(judged: list[Judgements], within: float | None, progress: Progress) -> Analyse:
    """Returns the function that analyses a study, shows its progress, and adds the study's verdicts
    to `judged`."""

    def analyse(study: Study, workers: Workers) -> tuple[Analysed, ...]:
        from plumbob.reports.analyses import analyses_of

        judged.append(judge_study(study, within))
        return analyses_of(study, workers, judged[-1], progress)

    return analyse


def print_study(
    chosen: argparse.Namespace,
    out: Path,
    study: Study,
    junit: Path | None,
    judged: Judgements,
    repeated: Sequence[RepeatedPair] = (),
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
