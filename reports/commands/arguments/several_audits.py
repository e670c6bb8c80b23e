"""Several audits by one command: which files are meant, and a row for each of them."""

from __future__ import annotations

import glob
import json
import math
import os
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from html import unescape
from pathlib import Path
from typing import Any
from urllib.parse import quote
from xml.etree import ElementTree

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.workers import Lost, Task, Workers
from plumbob.models.border import must_be, regular_file
from plumbob.reports.view.audit.page import page_of
from plumbob.reports.view.content import Finding
from plumbob.reports.view.finding_text import written as worded
from plumbob.reports.view.page import written
from plumbob.reports.view.tables import lines as worded_lines
from plumbob.reports.view.terminal import aligned

INCLUDED = re.compile(r"<(?:include|model)\b[^>]*\bfile\s*=\s*[\"']([^\"'\0]+)[\"']")
ROOT = re.compile(r"<mujoco[\s>]")
# A file with no other elements of MJCF than these is a part of models, and no model itself.
PARTS = frozenset(
    ("asset", "compiler", "custom", "default", "extension", "option", "size", "statistic")
) | {"actuator", "contact", "equality", "keyframe", "sensor", "tendon", "visual"}
REFUSED, LOST = 2, 3  # exit codes: the input; a process has died or hung
PAGE = "audit-models.html"
# of a row, which is no place of this page
OWN_PAGE = re.compile(r'href="#(audit-[^"]*\.html)"')
SETS = re.compile(r"\b(?:timestep|integrator|solref)\s*=")  # what a step's error depends on
ESCAPED = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A"})  # in a workflow command
IN_PROPERTY = ESCAPED | str.maketrans({":": "%3A", ",": "%2C"})
ANSWERS = ("reference", "your error", "to do")  # lines of an audit


@dataclass(frozen=True)
class Row:
    """The audit of a file, or why it has none."""

    path: str
    error: float | None  # [m], of the model's own step; infinite where it diverges
    step: float | None  # [s]
    says: str  # what to do about it, or why there is no audit
    code: int  # the exit code that this file alone would have
    data: dict[str, Any]  # what --json prints of it
    page: str = ""  # name of the file's own page
    missed: str = ""  # what is asked for, and why
    lines: tuple[str, ...] = ()  # of its answer
    seconds: float = 0.0  # wall time

    @property
    def diverges(self) -> bool:
        """Whether the run at the model's own step does."""
        return self.error is not None and math.isinf(self.error)


def refused(path: str, why: str, code: int = REFUSED) -> Row:
    """The row of a file that has no audit."""
    data = {"model": path, "path": path, "error": None, "why": why}
    return Row(path, None, None, why, code, data)


def model_files(
    words: Sequence[str], models_only: bool = False
) -> tuple[list[Path] | None, list[Path]]:
    """Returns the files that `words` mean and the .xml files that are skipped, as they hold no
    model. A word is a file, a pattern, or a folder, which means every model below it that no other
    model there includes. The first value is None if the only word is one file. Files are skipped in
    folders, with `models_only` everywhere. Raises ParameterError if a word means no file."""
    alone = len(words) == 1 and not Path(words[0]).is_dir() and not _is_pattern(words[0])
    if alone and not models_only:
        return None, []
    meant: list[Path] = []
    others: list[Path] = []
    for word in words:
        if Path(word).is_dir():
            files, skipped = _models_in(Path(word))
            others += skipped
        elif _is_pattern(word):
            files = sorted(map(Path, glob.glob(word, recursive=True)))
        else:
            files = [Path(word)]
        if not files:
            raise ParameterError(
                "model", word, "a file, or a folder or pattern with models in it"
            )
        meant += files
    if models_only:
        others += [file for file in meant if not _is_model(file, _text(file))]
    chosen = [file for file in dict.fromkeys(meant) if file not in others]
    return (None if alone and chosen else chosen), others


def _is_pattern(word: str) -> bool:
    return glob.has_magic(word) and not Path(word).exists()


def _models_in(folder: Path) -> tuple[list[Path], list[Path]]:
    """The MJCF models below `folder` that no other file there includes, each once, and the files
    there that hold no model."""
    texts = {path: _text(path) for path in sorted(folder.rglob("*.xml"))}
    parts = {
        os.path.realpath(path.parent / part)
        for path, text in texts.items()
        for part in INCLUDED.findall(text or "")
    }
    first = {os.path.realpath(path): path for path in reversed(texts)}
    whole = sorted(path for real, path in first.items() if real not in parts)
    models = [path for path in whole if _is_model(path, texts[path])]
    return models, [path for path in whole if path not in models]


def _text(path: Path) -> str | None:
    """The text of a file; None if the file is not regular, too large for a model or unreadable."""
    try:
        regular_file("model", path)
        with must_be("a file that can be read", "model", str(path)):
            return path.read_text("utf-8", "replace")
    except ParameterError:
        return None


def _is_model(path: Path, text: str | None) -> bool:
    """Whether a file holds a model, or might hold one: its row then says why it has no audit."""
    if text is None or path.suffix != ".xml":
        return True
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError):
        return ROOT.search(text) is not None
    return root.tag == "mujoco" and not PARTS.issuperset(child.tag for child in root)


def audited(
    files: Sequence[Path], do: Callable[[Path], Row], jobs: int, limit: float
) -> Iterator[Row]:
    """A row for each file as they are done, in up to `jobs` processes, the largest first, since one
    that takes long and begins last is waited for; one that dies, or takes more processor time than
    `limit` [s], costs its own row."""

    def size(path: Path) -> int:
        return path.stat().st_size if path.is_file() else 0

    largest_first = sorted(files, key=size, reverse=True)
    tasks = [Task(path, do, (path,), limit, label=str(path)) for path in largest_first]
    with Workers(min(jobs, len(tasks))) as workers:
        for task, row in workers.results(tasks):
            path = str(task.key)
            yield refused(path, row.why, LOST) if isinstance(row, Lost) else row


def sorted_rows(rows: Sequence[Row]) -> list[Row]:
    """The largest error first, what has none last."""
    return sorted(rows, key=lambda row: (row.error is None, -(row.error or 0.0), row.path))


def shared_folder(paths: Sequence[str]) -> str:
    """The folder that all these files share."""
    return os.path.commonpath([os.path.dirname(os.path.abspath(path)) for path in paths])


def page_names(files: Sequence[Path]) -> dict[str, str]:
    """The name of each file's page, without its ending: its path from the folder that all share,
    and -2 where another page has that name."""
    shared = shared_folder(list(map(str, files)))
    taken = {PAGE.removesuffix(".html")}
    names = dict[str, str]()
    for path in map(str, files):
        parts = Path(os.path.relpath(path, shared)).parts
        name = "-".join(("audit", *parts)).removesuffix(".xml")
        while name in taken:
            name += "-2"
        names[path] = name
        taken.add(name)
    return names


def named(rows: Sequence[Row]) -> list[tuple[str, Row]]:
    """The rows with their paths from the folder that all share."""
    shared = shared_folder([row.path for row in rows])
    return [(os.path.relpath(row.path, shared), row) for row in rows]


def table(rows: Sequence[Row]) -> Finding:
    """The rows as a page and a terminal have them."""
    (finding,) = worded("audit/several", {"rows": named(rows)})
    return finding


def lines(rows: Sequence[Row]) -> list[str]:
    """The table as text; nothing without rows."""
    return list(aligned(table(rows).tables[0])) if rows else []


def workflow_commands(row: Row) -> Iterator[str]:
    """Workflow commands of GitHub: the answer of an audit on each line of its file that sets the
    step, the integrator or contacts, or on the first."""
    file = Path(row.path)
    text = file.read_text("utf-8", "replace") if file.is_file() else ""
    numbers = [n for n, line in enumerate(text.splitlines(), 1) if SETS.search(line)] or [1]
    answer = "\n".join(line for line in row.lines if line.startswith(ANSWERS))
    message = (row.missed or (row.says if row.code else answer)).translate(ESCAPED)
    kind = "error" if row.code else "notice"
    place = row.path.translate(IN_PROPERTY)
    for number in numbers:
        yield f"::{kind} file={place},line={number},title=plumbob audit::{message}"


def write_page(rows: Sequence[Row], folder: Path, command: str, seconds: float) -> Path:
    """Write the page of the table into `folder`, whole or not at all. Raises OSError."""
    text = page_of(table(rows), command, seconds)

    def link(found: re.Match[str]) -> str:
        return f'href="{quote(unescape(found[1]), errors="surrogateescape")}"'

    return written(OWN_PAGE.sub(link, text), folder, PAGE)


def write_badge(file: Path, rows: Sequence[Row], bounded: bool) -> None:
    """Write the largest error as shields.io draws an endpoint: red where what is asked for is
    missed or a file has no audit, grey without a reference, green within a bound, else blue."""
    (message,) = worded_lines("audit_badge", rows=sorted_rows(rows))
    colour = "brightgreen" if bounded else "blue"
    if any(row.code for row in rows):
        colour = "red"
    elif any(row.error is None for row in rows):
        colour = "lightgrey"
    badge = {
        "schemaVersion": 1,
        "label": "simulation error",
        "message": message,
        "color": colour,
    }
    written(json.dumps(badge), file.parent, file.name)


def write_junit(file: Path, rows: Sequence[Row], began: float) -> None:
    """Write a test case for each model that was audited from the time `began` [s] on: a failure
    where what is asked for is missed, an error where there is no audit, skipped where there is no
    reference."""
    from plumbob.reports.view.junit import Case, write_cases

    cases = []
    for name, row in named(rows):
        numbers = ("step", "error", "uncertainty", "certified_until")
        given = ((n, row.data.get(n)) for n in numbers)
        known = {n: f"{v:.6g}" for n, v in given if v is not None and math.isfinite(v)}
        outcome = "", ""
        if row.code:
            outcome = ("failure", row.missed) if row.missed else ("error", row.says)
        elif row.error is None:
            outcome = "skipped", f"no reference: {row.data.get('why', row.says)}"
        cases.append(Case("plumbob.audit", name, row.seconds, known, *outcome))
    date = datetime.fromtimestamp(began, UTC).strftime("%Y-%m-%dT%H:%M:%S")
    write_cases(file, cases, sum(row.seconds for row in rows), date)
