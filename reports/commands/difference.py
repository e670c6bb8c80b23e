"""plumbob difference: whether rounding explains what two recorded motions of a model differ by, and
which of their steps are not the model's."""

from __future__ import annotations

import argparse
from pathlib import Path

from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.arguments.console import progress, writable_folder
from plumbob.reports.commands.shared.model_file import read_controls
from plumbob.reports.view.own_files import check_replaceable

PRECISION_NAMES = "float64 or float32"
UNDECIDED = 3


def command(chosen: argparse.Namespace) -> int:
    """Prints the comparison of one or two recordings. Returns 1 if rounding and the solver do not
    explain what differs, 3 if the time ended before all steps were checked."""
    from plumbob.reports.difference_from_python import difference
    from plumbob.reports.view.difference import (
        DIFFERENCE_PAGE,
        difference_record,
        write_difference_page,
    )

    folder = Path(chosen.out) if chosen.out else None
    if folder is not None:
        check_replaceable("out", folder / DIFFERENCE_PAGE)
        writable_folder("out", folder)
    controls = read_controls(Path(chosen.controls)) if chosen.controls else None
    with progress() as show:
        result = difference(
            chosen.a,
            chosen.b,
            Path(chosen.model),
            controls,
            precision=chosen.precision,
            keyframe=chosen.keyframe,
            budget=chosen.budget,
            progress=lambda what: show(what, 0, 0),
        )
    page = folder and write_difference_page(result, folder, chosen.line)
    if chosen.json:
        values.print_json(difference_record(result))
    else:
        print(result.text())
        if page:
            print(f"page: {page}")
    if result.verdict == "open":
        return UNDECIDED
    return 0 if result.explained else 1
