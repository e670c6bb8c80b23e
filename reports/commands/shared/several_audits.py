"""Audits of several models by one command: the files, a row for each file, and the table of all."""

from __future__ import annotations

import argparse
import glob
import json
import math
import os
import re
import sys
import time
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
from plumbob.reports.columns.audit_columns import audit_columns
from plumbob.reports.commands.arguments import values
from plumbob.reports.view.audit.html import AuditPage, audit_html
from plumbob.reports.view.content import Finding
from plumbob.reports.view.finding_text import read_findings as worded
from plumbob.reports.view.page import write_file
from plumbob.reports.view.tables import terminal_lines as worded_lines
from plumbob.reports.view.terminal import aligned

INCLUDED_FILE = re.compile(r"<(?:include|model)\b[^>]*\bfile\s*=\s*[\"']([^\"'\0]+)[\"']")
ROOT_ELEMENT = re.compile(r"<mujoco[\s>]")
# A file whose elements are all among these is a part of other models, and no model itself.
PART_ELEMENTS = frozenset(
    ("asset", "compiler", "custom", "default", "extension", "option", "size", "statistic")
) | {"actuator", "contact", "equality", "keyframe", "sensor", "tendon", "visual"}
REFUSED, LOST = 2, 3  # exit codes: bad input; a process that died or hung
PAGE = "audit-models.html"
# A link to the page of one audit: the page's builder writes it as a place of the same page.
PAGE_LINK = re.compile(r'href="#(audit-[^"]*\.html)"')
# The attributes of MJCF on which the error of a step depends.
STEP_SETTINGS = re.compile(r"\b(?:timestep|integrator|solref)\s*=")
# Escapes of the message in a workflow command.
ESCAPES = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A"})
PROPERTY_ESCAPES = ESCAPES | str.maketrans({":": "%3A", ",": "%2C"})
# First words of the lines of an audit that GitHub shows.
ANSWERS = ("reference", "your error", "to do")


@dataclass(frozen=True)
class Row:
    """The result of auditing one file, or the reason why the file has no audit."""

    path: str
    error: float | None  # [m] error at the model's own step; infinite if the run diverges
    step: float | None  # [s] the model's own step
    says: str  # advice of the audit, or the reason why there is none
    code: int  # exit code of an audit of this file alone
    data: dict[str, Any]  # record that --json prints
    page: str = ""  # name of the file's own page
    missed: str = ""  # requirements that the audit misses, with reasons
    lines: tuple[str, ...] = ()  # all lines of the audit on the terminal
    short: tuple[str, ...] = ()  # its most important lines; empty if all are printed
    seconds: float = 0.0  # [s] wall time of the audit

    @property
    def diverges(self) -> bool:
        """Whether the run at the model's own step diverges."""
        return self.error is not None and math.isinf(self.error)


def refused_row(path: str, why: str, code: int = REFUSED) -> Row:
    """Returns the row of a file that has no audit, for the reason `why`."""
    data = {"model": path, "path": path, "error": None, "why": why}
    return Row(path, None, None, why, code, data)


def model_files(
    words: Sequence[str], models_only: bool = False
) -> tuple[list[Path] | None, list[Path]]:
    """Returns the model files that `words` mean, and the .xml files that hold no model and are
    skipped. A word is a file, a pattern or a folder. A folder means every model below it that no
    other model in that folder includes. The first value is None if the only word is one file. Files
    are skipped in folders; with `models_only`, they are skipped everywhere. Raises ParameterError
    if a word means no file."""
    alone = len(words) == 1 and not Path(words[0]).is_dir() and not _is_pattern(words[0])
    if alone and not models_only:
        return None, []
    named_files: list[Path] = []
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
        named_files += files
    if models_only:
        others += [file for file in named_files if not _is_model(file, _text(file))]
    chosen = [file for file in dict.fromkeys(named_files) if file not in others]
    return (None if alone and chosen else chosen), others


def _is_pattern(word: str) -> bool:
    """Returns whether `word` is a pattern with wildcards and not the name of a file."""
    return glob.has_magic(word) and not Path(word).exists()


def _models_in(folder: Path) -> tuple[list[Path], list[Path]]:
    """Returns the MJCF models below `folder` that no other file in it includes, and the files that
    hold no model. A file with several paths is returned once."""
    texts = {path: _text(path) for path in sorted(folder.rglob("*.xml"))}
    included_files = set[str]()
    for path, text in texts.items():
        for name in INCLUDED_FILE.findall(text or ""):
            included_files.add(os.path.realpath(path.parent / name))
    path_by_real = {os.path.realpath(path): path for path in reversed(texts)}
    top_files = sorted(
        path for real, path in path_by_real.items() if real not in included_files
    )
    models = [path for path in top_files if _is_model(path, texts[path])]
    return models, [path for path in top_files if path not in models]


def _text(path: Path) -> str | None:
    """Returns the text of a file; None if the file is not regular, too large for a model or
    unreadable."""
    try:
        regular_file("model", path)
        with must_be("a file that can be read", "model", str(path)):
            return path.read_text("utf-8", "replace")
    except ParameterError:
        return None


def _is_model(path: Path, text: str | None) -> bool:
    """Returns whether a file holds a model. A file that cannot be read or parsed counts as a model,
    so that its row says why it has no audit."""
    if text is None or path.suffix != ".xml":
        return True
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError):
        return ROOT_ELEMENT.search(text) is not None
    return root.tag == "mujoco" and not PART_ELEMENTS.issuperset(child.tag for child in root)


def audit_rows(
    files: Sequence[Path], audit_row: Callable[[Path], Row], jobs: int, limit: float
) -> Iterator[Row]:
    """Gives the row of each file as soon as `audit_row` has returned it, from up to `jobs`
    processes. The largest file is audited first: a long audit that begins last would delay the end.
    If a process dies or takes more processor time than `limit` [s], its file has a row with the
    reason."""

    def size(path: Path) -> int:
        return path.stat().st_size if path.is_file() else 0

    largest_first = sorted(files, key=size, reverse=True)
    tasks = [Task(path, audit_row, (path,), limit, label=str(path)) for path in largest_first]
    with Workers(min(jobs, max(len(tasks), 1))) as workers:
        for task, row in workers.results(tasks):
            path = str(task.key)
            if isinstance(row, Lost):
                yield refused_row(path, row.why, LOST)
            else:
                yield row


def sorted_rows(rows: Sequence[Row]) -> list[Row]:
    """Returns the rows by falling error; rows without an error come last."""
    return sorted(rows, key=lambda row: (row.error is None, -(row.error or 0.0), row.path))


def shared_folder(paths: Sequence[str]) -> str:
    """Returns the deepest folder that contains all these files."""
    return os.path.commonpath([os.path.dirname(os.path.abspath(path)) for path in paths])


def page_names(files: Sequence[Path]) -> dict[str, str]:
    """Returns the name of each file's page without its ending, by the path of the file. The name is
    `audit` and the path from the folder that all files share; -2 is added if another page has that
    name."""
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


def relative_rows(rows: Sequence[Row]) -> list[tuple[str, Row]]:
    """Returns the rows with their paths relative to the folder that all files share."""
    shared = shared_folder([row.path for row in rows])
    return [(os.path.relpath(row.path, shared), row) for row in rows]


def audit_table(rows: Sequence[Row]) -> Finding:
    """Returns the table of all audits, for a page and for the terminal."""
    (finding,) = worded("audit/several", {"rows": relative_rows(rows)})
    return finding


def table_lines(rows: Sequence[Row]) -> list[str]:
    """Returns the lines of the table of all audits; an empty list if there are no rows."""
    return list(aligned(audit_table(rows).tables[0])) if rows else []


def workflow_commands(row: Row) -> Iterator[str]:
    """Gives the workflow commands with which GitHub annotates a file with its audit. Each line that
    sets the step, the integrator or contacts has an annotation; if no line does, the first line has
    one."""
    file = Path(row.path)
    text = file.read_text("utf-8", "replace") if file.is_file() else ""
    line_numbers = [
        number for number, line in enumerate(text.splitlines(), 1) if STEP_SETTINGS.search(line)
    ]
    answers = [line for line in row.lines if line.startswith(ANSWERS)]
    # The answer of an audit without a reference is its second line.
    answer = "\n".join(answers or row.lines[1:2])
    if row.code:
        answer = row.missed or row.says
    message = answer.translate(ESCAPES)
    kind = "error" if row.code else "notice"
    place = row.path.translate(PROPERTY_ESCAPES)
    for number in line_numbers or [1]:
        yield f"::{kind} file={place},line={number},title=plumbob audit::{message}"


def write_page(rows: Sequence[Row], folder: Path, command: str, seconds: float) -> Path:
    """Writes the page with the table of all audits into `folder`, whole or not at all, and returns
    its path. The audits took `seconds` [s]. Raises OSError."""
    text = audit_html(AuditPage(audit_table(rows), command, seconds))

    def quoted_link(link: re.Match[str]) -> str:
        file_name = unescape(link[1])
        return f'href="{quote(file_name, errors="surrogateescape")}"'

    return write_file(PAGE_LINK.sub(quoted_link, text), folder, PAGE)


def write_badge(file: Path, rows: Sequence[Row], bounded: bool) -> None:
    """Writes the largest error as a JSON endpoint of shields.io. The badge is red if a requirement
    is missed or a file has no audit, grey if an error has no reference, green if errors are
    `bounded` by the user, and otherwise blue."""
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
    write_file(json.dumps(badge), file.parent, file.name)


def write_junit(file: Path, rows: Sequence[Row], began: float) -> None:
    """Writes a JUnit file with a test case for each model. A missed requirement is a failure, a
    model without an audit is an error, and a model without a reference is skipped. The audits began
    at the time `began` [s]."""
    from plumbob.reports.view.junit import JunitCase, write_cases

    cases = []
    for name, row in relative_rows(rows):
        numbers = ("step", "error", "uncertainty", "certified_until")
        quantities = ((number, row.data.get(number)) for number in numbers)
        properties = {
            name: f"{value:.6g}"
            for name, value in quantities
            if value is not None and math.isfinite(value)
        }
        outcome = "", ""
        if row.missed:
            outcome = "failure", row.missed
        elif row.code:
            outcome = "error", row.says
        elif row.error is None:
            outcome = "skipped", f"no reference: {row.data.get('why', row.says)}"
        cases.append(JunitCase("plumbob.audit", name, row.seconds, properties, *outcome))
    date = datetime.fromtimestamp(began, UTC).strftime("%Y-%m-%dT%H:%M:%S")
    write_cases(file, cases, sum(row.seconds for row in rows), date)


def write_table(rows: Sequence[Row], chosen: argparse.Namespace, began: float) -> None:
    """Writes the page of the table, the JUnit file and the badge that the user asks for, and prints
    where the page is. The audits began at the time `began` [s]."""
    if chosen.out is not None:
        out = Path(chosen.out)
        if not chosen.alone:
            seconds = time.time() - began
            page_file = write_page(rows, out, chosen.line, seconds)
            print(page_file, file=sys.stderr)
        elif rows[0].page:
            print(out / rows[0].page, file=sys.stderr)
    if chosen.junitxml:
        write_junit(Path(chosen.junitxml), rows, began)
    if chosen.badge:
        write_badge(Path(chosen.badge), rows, chosen.absolute is not None)


def print_rows(rows: Sequence[Row], chosen: argparse.Namespace) -> None:
    """Prints the audit if there is one model, else the table of all; on stderr, the workflow
    commands and what is missed."""
    alone = chosen.alone
    if values.as_table(chosen):
        values.print_table(
            chosen, audit_columns([{**row.data, "path": row.path} for row in rows])
        )
    elif not alone and chosen.json:
        values.print_json([{**row.data, "path": row.path} for row in rows])
    elif chosen.json and rows[0].lines:
        values.print_json(rows[0].data)
    elif alone:
        # The first line of a motion's audit is printed before the audit begins.
        still = chosen.contacts or chosen.holds or chosen.reproducible
        first = 0 if still else 1
        for line in (rows[0].short or rows[0].lines)[first:]:
            print(line)
    else:
        for line in table_lines(rows):
            print(line)
    if chosen.github:
        for row in rows:
            print(*workflow_commands(row), sep="\n", file=sys.stderr)
    for row in rows:
        if row.missed or (alone and row.code):
            print("plumbob:", *(row.missed or row.says).split(), file=sys.stderr)
