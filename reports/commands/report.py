"""plumbob report: the page of a stored study, drawn again; nothing is run."""

from __future__ import annotations

import argparse
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store
from plumbob.reports.commands import values


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("out", metavar="OUT", help="a results folder of `plumbob validate`")
    parser.add_argument("--study", metavar="N", help="number of the study (default: the newest)")


def command(chosen: argparse.Namespace) -> int:
    """Write the same page that `validate` wrote, to the byte, and print where it is."""
    number = None if chosen.study is None else values.count("study", chosen.study)
    study = store.load(Path(chosen.out) / store.FILE, number)
    if study is None and number is None:
        raise ParameterError("OUT", chosen.out, "where `plumbob validate` has stored a study")
    if study is None:
        raise ParameterError("study", number, f"the number of a study in {chosen.out}")
    from plumbob.reports.findings import section
    from plumbob.reports.view.page import write_page
    from plumbob.reports.view.replay import replay

    print(write_page(study, Path(chosen.out), section, replays=replay))
    return 0
