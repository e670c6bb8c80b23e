"""Which files plumbob wrote, by a mark in each or by a list: no other file is ever replaced."""

from __future__ import annotations

import os
import re
from pathlib import Path

from plumbob.analytic.parameters import ParameterError

LIST = "files.txt"  # in a folder of pages: the names of all files there, one a line
HEAD = 4096  # bytes at the beginning of a file that hold its mark
# A page, of earlier versions too, has a content security policy, and plumbob in its title. A JUnit
# file names its suite, a badge its label.
MARK = re.compile(
    rb"""content="default-src 'none';[^<]*>.*<title>[^<]*plumbob|<testsuite name="plumbob"|"""
    rb"""\A\{"schemaVersion": 1, "label": "simulation error\"""",
    re.DOTALL,
)
BESIDE = re.compile(r"[\"/]([^\"/]+\.(?:js|css|svg|png))\"")  # a file that a page loads


def replaceable(name: str, file: Path) -> Path:
    """Returns `file` with its links resolved, if the file is new, empty, or bears the mark of a
    file that plumbob wrote; raises ParameterError with the `name` of an option."""
    if os.path.lexists(file) and not (file.is_file() and _marked(file)):
        raise _foreign(name, file)
    return file.resolve()


def replaceable_folder(name: str, folder: Path) -> None:
    """Raises ParameterError with the `name` of an option if there is a file in a folder of pages
    that plumbob did not write."""
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise _foreign(name, folder)
    own = _listed(folder)
    for path in sorted(folder.rglob("*")):
        if str(path.relative_to(folder)) not in own:
            raise _foreign(name, path)


def _foreign(name: str, path: Path) -> ParameterError:
    what = "a new file, or one that plumbob wrote: another is neither replaced nor removed"
    return ParameterError(name, str(path), what)


def _marked(file: Path) -> bool:
    with file.open("rb") as opened:
        head = opened.read(HEAD)
    return not head or MARK.search(head) is not None


def _listed(folder: Path) -> set[str]:
    """The names of the files that plumbob wrote in a folder of pages. If an earlier version wrote
    them, there is no list: they are the pages with a mark, and the files that these pages or the
    index load."""
    if (folder / LIST).is_file():
        return {LIST, *(folder / LIST).read_text("utf-8", "replace").splitlines()}
    pages = [page for page in folder.glob("*.html") if page.is_file() and _marked(page)]
    index = [page for page in folder.parent.glob("index.html") if pages]
    texts = (page.read_text("utf-8", "replace") for page in [*pages, *index])
    return {page.name for page in pages}.union(*map(BESIDE.findall, texts))
