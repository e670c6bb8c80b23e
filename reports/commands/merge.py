"""plumbob merge: makes one study, sweep or table of audits of the shards that --shard measured."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store as study_store
from plumbob.engines.study.shard import SHARD_FOLDERS
from plumbob.engines.sweep import store as sweep_store
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.arguments.console import note, progress, writable_folder
from plumbob.reports.commands.shared import audit_shards

INCOMPLETE = 3


def command(chosen: argparse.Namespace) -> int:
    """Merges the shards, prints the results and writes the pages, as one command without --shard
    does. Returns the exit code of that command."""
    folders = [Path(folder) for folder in dict.fromkeys(chosen.folders)]
    out = Path(chosen.out)
    if out.resolve() in [folder.resolve() for folder in folders]:
        raise ParameterError("out", chosen.out, "another folder than those of the shards")
    kinds = {_kind_of_shards(folder) for folder in folders}
    if len(kinds) > 1:
        raise ParameterError(SHARD_FOLDERS, " ".join(chosen.folders), "shards of one command")
    (kind,) = kinds
    writable_folder("out", out)
    if kind == "sweep":
        values.refuse_options(chosen, ("within", "junitxml", "verbose"), "left out for a sweep")
        return _merge_sweep(chosen, folders, out)
    if kind == "audit":
        values.refuse_options(chosen, ("within", "verbose"), "left out for audits")
        return _merge_audits(chosen, folders, out)
    return _merge_study(chosen, folders)


def _kind_of_shards(folder: Path) -> str:
    """Returns the command whose shards a folder holds: validate, sweep or audit. Raises
    ParameterError if it holds none, or shards of several commands."""
    holds = {
        "validate": study_store.has_shards(folder / study_store.FILE),
        "sweep": study_store.has_shards(folder / sweep_store.FILE),
        "audit": any(audit_shards.audit_shards(folder)),
    }
    kinds = [kind for kind, there in holds.items() if there]
    if len(kinds) != 1:
        several = f": it holds shards of {' and '.join(kinds)}" if kinds else ""
        expected = f"a folder with a whole shard of one command{several}"
        raise ParameterError(SHARD_FOLDERS, str(folder), expected)
    return kinds[0]


def _merge_study(chosen: argparse.Namespace, folders: Sequence[Path]) -> int:
    """Merges shards of a study."""
    from plumbob.engines.study.checkpoint import measured_into
    from plumbob.engines.study.merge import merged_study
    from plumbob.engines.workers import Workers
    from plumbob.reports.commands.shared.study_answer import (
        analyse_into,
        print_study,
        study_targets,
    )
    from plumbob.reports.judge.study_verdicts import Judgements

    out, junit = study_targets(chosen)
    chosen.like = None
    judged = list[Judgements]()
    jobs = chosen.jobs or os.cpu_count() or 1
    with Workers(jobs) as workers, measured_into(out / study_store.FILE, note=note) as kept:
        with progress() as show:
            analyse = analyse_into(judged, chosen.within, show)
            study = merged_study(folders, kept, workers, analyse)
        for task in kept.given_up:
            note(f"given up: {task}; measure its shard again")
        code = print_study(chosen, out, study, junit, judged[0])
        return code or (INCOMPLETE if kept.given_up else 0)


def _merge_sweep(chosen: argparse.Namespace, folders: Sequence[Path], out: Path) -> int:
    """Merges shards of a sweep."""
    from plumbob.reports.commands.shared.sweep_answer import print_sweep

    swept, key = sweep_store.merged_sweep(folders, out)
    print_sweep(chosen, swept, key, 0)
    return 0


def _merge_audits(chosen: argparse.Namespace, folders: Sequence[Path], out: Path) -> int:
    """Merges shards of the audits of several models."""
    from plumbob.reports.commands.shared import several_audits

    began = time.time()
    rows = several_audits.sorted_rows(audit_shards.merged_audits(folders, out))
    chosen.alone, chosen.github, chosen.badge = False, False, None
    several_audits.write_table(rows, chosen, began)
    several_audits.print_rows(rows, chosen)
    return max((row.code for row in rows), default=0)
