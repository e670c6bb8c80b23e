"""A study of searches alone: no errors of scenes and no costs are measured."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plumbob.engines.method import Method
    from plumbob.engines.study.request import RunRequest
    from plumbob.engines.study.results import Study

FILE = "stability.sqlite3"  # name of the store in the folder of results


def search_study(
    chosen: argparse.Namespace,
    methods: Sequence[Method],
    searches: Sequence[RunRequest[Any]],
    out: str | None = None,
) -> Study:
    """Returns a study that holds the results of `searches` alone, stored in the folder `out` if
    there is one. Raises ParameterError if nothing can be written into that folder."""
    from plumbob.engines.study.checkpoint import measured_into
    from plumbob.engines.study.runner import run_study
    from plumbob.reports.commands.arguments.console import note, progress, writable_folder

    jobs = min(chosen.jobs or os.cpu_count() or 1, len(searches))
    file = writable_folder("out", Path(out)) / FILE if out else None
    with measured_into(file, note=note) as checkpoint, progress() as show:
        return run_study(
            (),
            methods,
            jobs=jobs,
            progress=show,
            timed=False,
            requests=lambda plan: searches,
            command=chosen.line,
            kept=checkpoint,
        )
