"""plumbob report: the pages of a stored study, drawn again; nothing is run."""

from __future__ import annotations

import argparse
import os
import shlex
from dataclasses import replace
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store
from plumbob.engines.study.results import Study

FILES = ("--out", "--junitxml", "--like")  # options of `validate` that take a file or a folder


def command(chosen: argparse.Namespace) -> int:
    """Write the same pages that `validate` wrote, to the byte, or one file with the content of all
    of them, or a folder to publish, and print where it is."""
    single = chosen.single
    public = None
    if chosen.publish is not None:
        public = new_folder(chosen.publish, Path(chosen.out))
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
        print(_drawn(study, Path(chosen.out), single, public))
    except (ParameterError, OSError, MemoryError):
        raise
    except Exception:
        # Numbers that somebody has changed may be of the right types and still break a template: a
        # list of another length, a name that nothing has. If the study's numbers follow from its
        # runs, the template has a defect.
        from plumbob.reports.analyses import follow

        if follow(study):
            raise
        what = f"a study whose numbers follow from its runs (that of {study.provenance.date})"
        raise ParameterError("OUT", chosen.out, what) from None
    return 0


def _drawn(study: Study, out: Path, single: Path | None, public: Path | None) -> Path:
    """Write the pages of a study into `out`, into the file `single`, or to publish into `public`;
    returns the path of the first page."""
    from plumbob.reports.view.page import write_file
    from plumbob.reports.view.site.writing import site_content, site_in_one_file, write_page

    if single:
        return write_file(site_in_one_file(site_content(study)), single.parent, single.name)
    if not public:
        return write_page(study, out)
    command_line = without_folders(study.provenance.command)
    page = write_page(
        replace(study, provenance=replace(study.provenance, command=command_line)), public
    )
    write_file("", public, ".nojekyll")  # GitHub Pages then serves the files as they are
    return page


def without_folders(command: str) -> str:
    """The command with the paths of files and folders cut to their last names: a published page
    does not tell where they are on the machine."""
    shown = []
    value = False  # the word is the value of an option that takes a file or a folder
    for word in shlex.split(command):
        option, equals, path = word.partition("=")
        asked = len(option) > 2 and any(name.startswith(option) for name in FILES)
        if asked and equals:
            word = f"{option}={Path(path).name}"
        elif value or word.startswith(("/", "~", ".")):
            word = Path(word).name
        value = asked and not equals
        shown.append(word)
    return shlex.join(shown)


def new_folder(text: str, out: Path) -> Path:
    """A folder to publish the pages of `out` in, empty or not there yet, and beside `out`; raises
    ParameterError."""
    folder = Path(text).resolve()
    empty = folder.is_dir() and os.access(folder, os.R_OK) and not any(folder.iterdir())
    if (
        (os.path.lexists(folder) and not empty)
        or folder.is_relative_to(out.resolve())
        or not os.access(folder.parent, os.W_OK)
    ):
        raise ParameterError(
            "publish",
            text,
            "an empty folder or a new one, outside OUT, where one can be written",
        )
    return folder
