"""plumbob report: the pages of a stored study, drawn again; nothing is run."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store
from plumbob.reports.commands.arguments import values


def arguments(parser: argparse.ArgumentParser) -> None:
    """Take --jobs too, which does nothing: one process draws, it takes seconds."""
    parser.add_argument("--jobs", help=argparse.SUPPRESS)


def command(chosen: argparse.Namespace) -> int:
    """Write the same pages that `validate` wrote, to the byte, or one file with the content of all
    of them, and print where it is."""
    number = None if chosen.study is None else values.count("study", chosen.study)
    single = None if chosen.single is None else html_file("single", chosen.single)
    values.jobs(chosen)
    study = store.load(Path(chosen.out) / store.FILE, number)
    if study is None and number is None:
        raise ParameterError("OUT", chosen.out, "where `plumbob validate` has stored a study")
    if study is None:
        raise ParameterError("study", number, f"the number of a study in {chosen.out}")
    from plumbob.reports.view.page import written
    from plumbob.reports.view.site.versions import versions
    from plumbob.reports.view.site.writing import render, write_page

    history = store.history(Path(chosen.out) / store.FILE)
    if single is None:
        print(write_page(study, Path(chosen.out), history))
    else:
        text = render(study, versions(history, chosen.out))
        print(written(text, single.parent, single.name))
    return 0


def html_file(name: str, text: str) -> Path:
    """A file .html that can be written; raises ParameterError with the `name` of the option."""
    file = Path(text)
    occupied = os.path.lexists(file) and not file.is_file()
    if file.suffix != ".html" or occupied or not os.access(file.parent, os.W_OK):
        raise ParameterError(name, text, "a file .html in a folder that can be written to")
    return file
