"""plumbob report: draw the pages of a stored study again; nothing is run."""

from __future__ import annotations

import argparse
import os
import shlex
from dataclasses import replace
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store
from plumbob.engines.study.results import Study

# Options of `validate` that take a file or a folder.
PATH_OPTIONS = ("--out", "--junitxml", "--like")


def command(chosen: argparse.Namespace) -> int:
    """Writes the pages of a stored study and prints where they are: the same bytes that `validate`
    wrote, or one file with all pages, or a folder to publish."""
    single = chosen.single
    public = None
    if chosen.publish is not None:
        public = folder_to_publish(chosen.publish, Path(chosen.out))
    if single and public:
        raise ParameterError("publish", chosen.publish, "left out where --single is given")
    from plumbob.reports.view.site.writing import check_site_replaceable

    if not single and not public:
        check_site_replaceable("OUT", Path(chosen.out))
    study = store.load(Path(chosen.out) / store.FILE, chosen.study)
    if study is None and chosen.study is None:
        raise ParameterError("OUT", chosen.out, "where `plumbob validate` has stored a study")
    if study is None:
        raise ParameterError("study", chosen.study, f"the number of a study in {chosen.out}")
    try:
        print(_write_pages(study, Path(chosen.out), single, public))
    except (ParameterError, OSError, MemoryError):
        raise
    except Exception:
        # Stored numbers that somebody has changed may have the right types and still break a
        # template, such as a list of another length. If the numbers follow from the study's runs,
        # nobody has changed them: the template has a defect, and the error is raised again.
        from plumbob.reports.analyses import follow

        if follow(study):
            raise
        expected = "a study whose numbers follow from its runs"
        raise ParameterError(
            "OUT", chosen.out, f"{expected} (that of {study.provenance.date})"
        ) from None
    return 0


def _write_pages(study: Study, out: Path, single: Path | None, public: Path | None) -> Path:
    """Writes the pages of a study into the folder `out`, into the file `single` or into the folder
    `public`. Returns the path of the first page."""
    from plumbob.reports.view.page import write_file
    from plumbob.reports.view.site.writing import (
        site_content,
        site_in_one_file,
        write_study_pages,
    )

    if single:
        return write_file(site_in_one_file(site_content(study)), single.parent, single.name)
    if not public:
        return write_study_pages(study, out)
    command_line = without_folders(study.provenance.command)
    page = write_study_pages(
        replace(study, provenance=replace(study.provenance, command=command_line)), public
    )
    write_file("", public, ".nojekyll")  # GitHub Pages then serves the files unchanged
    return page


def without_folders(command: str) -> str:
    """Returns the command with the path of each file and folder cut to its last name, so that a
    published page does not show the folders of the machine."""
    shortened = []
    is_path = False  # whether the word is the value of an option that takes a file or a folder
    for word in shlex.split(command):
        option, equals, path = word.partition("=")
        # argparse takes any beginning of an option's name.
        takes_path = len(option) > 2 and any(name.startswith(option) for name in PATH_OPTIONS)
        if takes_path and equals:
            word = f"{option}={Path(path).name}"
        elif is_path or word.startswith(("/", "~", ".")):
            word = Path(word).name
        is_path = takes_path and not equals
        shortened.append(word)
    return shlex.join(shortened)


def folder_to_publish(text: str, out: Path) -> Path:
    """Returns the folder for the published pages: empty or new, and outside the results folder
    `out`. Raises ParameterError."""
    folder = Path(text).resolve()
    is_empty = folder.is_dir() and os.access(folder, os.R_OK) and not any(folder.iterdir())
    is_taken = os.path.lexists(folder) and not is_empty
    inside_out = folder.is_relative_to(out.resolve())
    if is_taken or inside_out or not os.access(folder.parent, os.W_OK):
        raise ParameterError(
            "publish",
            text,
            "an empty folder or a new one, outside OUT, where one can be written",
        )
    return folder
