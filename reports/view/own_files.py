"""Recognition of files that plumbob wrote, by a mark in the file or by a list: plumbob replaces no
other file."""

from __future__ import annotations

import os
import re
from pathlib import Path

from plumbob.analytic.parameters import ParameterError

FILE_LIST = "files.txt"  # names of all files in a folder of pages, one per line
HEAD = 4096  # [bytes] length of the beginning of a file that holds the mark
# Every version's page has a content security policy, and plumbob in its title. A JUnit file names
# its suite, a badge its label, the record of an audit begins with the model and its integrator, a
# shard of audits with its number.
OWN_FILE_MARK = re.compile(
    rb"""content="default-src 'none';[^<]*>.*<title>[^<]*plumbob|<testsuite name="plumbob"|"""
    rb"""\A\{"schemaVersion": 1, "label": "simulation error\"|"""
    rb"""\A\{\n "model": "[^\n]*",\n "integrator": \"|"""
    rb"""\A\{"measured": \{"shard": \{"number": """,
    re.DOTALL,
)
LOADED_FILE = re.compile(r"[\"/]([^\"/]+\.(?:js|css|svg|png))\"")  # a file that a page loads


def check_replaceable(name: str, file: Path) -> Path:
    """Returns `file` with its links resolved, if the file is new, is empty, or has the mark of a
    file that plumbob wrote. Otherwise raises ParameterError, naming the option `name`."""
    if os.path.lexists(file) and not (file.is_file() and _marked(file)):
        raise _foreign(name, file)
    return file.resolve()


def check_replaceable_folder(name: str, folder: Path) -> None:
    """Raises ParameterError, naming the option `name`, if `folder` holds a file that plumbob did
    not write."""
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise _foreign(name, folder)
    own_names = _own_names(folder)
    for path in sorted(folder.rglob("*")):
        if str(path.relative_to(folder)) not in own_names:
            raise _foreign(name, path)


def _foreign(name: str, path: Path) -> ParameterError:
    """Returns the error for an option `name` whose file plumbob did not write."""
    expected = "a new file, or one that plumbob wrote: another is neither replaced nor removed"
    return ParameterError(name, str(path), expected)


def _marked(file: Path) -> bool:
    """Returns whether a file is empty or has the mark of a file that plumbob wrote."""
    with file.open("rb") as opened:
        head = opened.read(HEAD)
    return not head or OWN_FILE_MARK.search(head) is not None


def _own_names(folder: Path) -> set[str]:
    """Returns the names of the files that plumbob wrote in a folder of pages.

    An earlier version left no list. In that case, the files are the pages with a mark, and the
    files that these pages or the index load."""
    if (folder / FILE_LIST).is_file():
        return {FILE_LIST, *(folder / FILE_LIST).read_text("utf-8", "replace").splitlines()}
    pages = [page for page in folder.glob("*.html") if page.is_file() and _marked(page)]
    index = list(folder.parent.glob("index.html")) if pages else []
    texts = [page.read_text("utf-8", "replace") for page in [*pages, *index]]
    return {page.name for page in pages}.union(*map(LOADED_FILE.findall, texts))
