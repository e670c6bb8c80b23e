"""plumbob validate: measure scenes with methods, judge the errors, and write the pages."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import Method
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study import store
from plumbob.engines.study.checkpoint import measured_into
from plumbob.engines.study.convergence import SEED
from plumbob.engines.study.extra_runs import Requests
from plumbob.engines.study.repeating import repeated_pairs
from plumbob.engines.study.runner import pairs, run_study
from plumbob.engines.workers import Workers
from plumbob.models.registry import matching_scenes as find_scenes
from plumbob.models.scene import Scene
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.arguments.console import note, progress
from plumbob.reports.commands.arguments.like import METHODS as LIKE_METHODS
from plumbob.reports.commands.arguments.like import SCENES as LIKE_SCENES
from plumbob.reports.commands.arguments.like import beside, own_method
from plumbob.reports.commands.shared.shards import (
    check_shard_options,
    print_shard,
    whole_command,
)
from plumbob.reports.commands.shared.study_answer import (
    analyse_into,
    print_study,
    study_targets,
)
from plumbob.reports.judge.study_verdicts import Judgements

if TYPE_CHECKING:
    from concurrent.futures import Executor

INCOMPLETE = 3


def command(chosen: argparse.Namespace) -> int:
    """Measures the scenes with the methods, prints the verdicts and writes the pages."""
    check_shard_options(chosen)
    scenes = find_scenes(chosen.scenes or (LIKE_SCENES if chosen.like else "*"), chosen.profile)
    methods = _methods(chosen.methods, chosen.like)
    if chosen.like:
        scenes = tuple(beside(scene, methods[0]) for scene in scenes)
    if not pairs(scenes, methods):
        raise _no_runs(scenes, methods)
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
    measured by the `executor` if there is one, else in `jobs` processes. Of a shard, the results
    are stored alone. Returns the exit code."""
    judged = list[Judgements]()  # one element, for the analyses and the terminal
    out, junit = study_targets(chosen)
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
                    requests=_needed_runs(chosen),
                    command=whole_command(chosen.line) if chosen.shard else chosen.line,
                    kept=checkpoint,
                    seed=chosen.seed or SEED,
                    analyse=analyse_into(judged, chosen.within, show),
                    shard=chosen.shard,
                )
            except BaseException as error:
                error.add_note(
                    "what is measured is stored: the same command goes on from there"
                )
                raise
            repeated = repeated_pairs(study, show) if chosen.repeat else ()
        for task in checkpoint.given_up:
            note(f"given up: {task}; the same command tries it again")
        lost = len(checkpoint.given_up)
        if chosen.shard:
            print_shard(chosen, len(study.convergence), "pair", lost)
            return INCOMPLETE if lost else 0
        report = ["plumbob", "report", str(out), "--study", str(checkpoint.number)]
        try:
            code = print_study(chosen, out, study, junit, judged[0], repeated)
            return code or (INCOMPLETE if lost else 0)
        except BaseException as error:
            error.add_note(f"the study is stored: `{shlex.join(report)}` draws its page")
            raise


def _needed_runs(chosen: argparse.Namespace) -> Requests:
    """Returns the function that requests the runs of findings, and of derivatives if the user asks
    for them. Findings on scenes and methods that the user has not chosen would take longest."""
    from plumbob.reports.analyses import requests
    from plumbob.reports.analyses.engines.gradients import with_each_pair

    needed = partial(requests, pairs_alone=bool(chosen.scenes or chosen.methods))
    return with_each_pair(needed) if chosen.gradients else needed


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


def _no_runs(scenes: Sequence[Scene], methods: Sequence[Method]) -> ParameterError:
    """Returns the error for methods of which none is meant for one of the scenes. The error names
    the other methods of the same engines that are."""
    engines = dict.fromkeys(method.engine for method in methods)
    methods_of_engines = find_methods(",".join(f"{engine}/*" for engine in engines))
    usable = dict.fromkeys(method.name for _, method in pairs(scenes, methods_of_engines))
    advice = f", such as {', '.join(usable)}" if usable else ""
    names = ", ".join(method.name for method in methods)
    return ParameterError("methods", names, f"methods that are meant for these scenes{advice}")
