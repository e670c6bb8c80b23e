"""Findings and galleries read from the text of their templates: words, tables, figures, statements.

A template of reports/templates is filled with stored numbers, by their names. Its text is read in
blocks that are separated by empty lines:

    judgement: confirmed             the head: lines of `name: value`, a `command` for each command
    command: plumbob solve {{ scene }}
    key finding: 1                   its place among the key findings of the index, if it is one

    # The title

    The summary; then further paragraphs, whose lines are joined.

    table: The caption               or `folded table` or `filtered table`
    | method | error |               the heads, then the rows
    | {{ method(name) }} | {{ value(error, 2) }} |
    note: What stands below it.

    statement: Chernousko 2020, (22)
    says: ...  value: ...  ours: ...  verdict: holds  why: ...  shown by: (each on a line)

    statements as a table            all of them, where this stands

    {{ figure("Title", "Caption.", [curve(times, errors, name="...")], linear("t"), linear("e")) }}

`plumbob.reports.view.tables` defines the tables, filters and functions. A macro in another file
gets all numbers as `numbers`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, cast

from plumbob.engines.study.results import Analysed
from plumbob.reports.records.claim import Claim
from plumbob.reports.records.exact_numbers import exact_numbers_of
from plumbob.reports.view.content import (
    Figure,
    Finding,
    Statement,
    StatementVerdict,
    Table,
)
from plumbob.reports.view.sources import CITED_SOURCES
from plumbob.reports.view.tables import TemplateParts, fill_text, read_table, table

KEY = re.compile(r"([a-z][a-z ]*): ?")
TABLES = ("table: ", "folded table: ", "filtered table: ")


class TextError(ValueError):
    """A template whose text cannot be read."""


def findings_of(analysis: Analysed) -> tuple[Finding, ...]:
    """Returns the finding, the galleries, or the figures and tables of a hard scene, that the
    template of an analysis writes from its stored numbers and from the shipped numbers of the
    template. A study of an older version also holds numbers that are shipped now; the shipped ones
    are shown.

    Raises jinja2.UndefinedError if the template needs a number that is not stored, and TextError if
    its text cannot be read."""
    claims = tuple(Claim(text, holds) for text, holds in analysis.claims)
    shipped = exact_numbers_of(analysis.template)
    if shipped is None:
        return read_findings(analysis.template, analysis.numbers, claims)
    numbers = {**analysis.numbers, **shipped.numbers}
    findings = read_findings(analysis.template, numbers, claims)
    return tuple(replace(finding, exact=shipped) for finding in findings)


def read_findings(
    template: str, numbers: Mapping[str, Any], claims: tuple[Claim, ...] = ()
) -> tuple[Finding, ...]:
    """Returns the findings that a template writes from `numbers`, one for each title in its text;
    each finding has all the `claims`. Raises the errors of `findings_of`."""
    parts = TemplateParts()
    text = fill_text(template, parts, {"numbers": numbers} | dict(numbers))
    head, *sections = re.split(r"^# ", text.strip(), flags=re.MULTILINE)
    keys = read_keys(head, template)
    default_name = template.rpartition("/")[2].replace("_", "-")
    untitled = Finding(
        name=keys.get("name", [default_name])[0],
        title="",
        judgement=keys.get("judgement", [""])[0],
        summary="",
        commands=tuple(keys.get("command", ())),
        key=int(keys.get("key finding", ["0"])[0]),
        claims=claims,
    )
    return tuple(_read_section(untitled, section, template, parts) for section in sections)


def _read_section(
    untitled: Finding, section: str, template: str, parts: TemplateParts
) -> Finding:
    """Returns the finding `untitled` with the title, paragraphs, tables, figures and statements of
    one section of a template's text."""
    title, *texts = re.split(r"\n(?:[ \t]*\n)+", section.strip())
    blocks = [parts.made.get(block, block) for block in map(str.strip, texts) if block]
    statements = list[Statement]()
    for block in blocks:
        if isinstance(block, Statement):
            statements.append(block)
        elif str(block).startswith("statement: "):
            statements.append(_read_statement(str(block), template))
    tables = list[Table]()
    paragraphs = list[str]()
    for block in blocks:
        if block == "statements as a table":
            tables.append(table("statements", statements=statements))
        elif isinstance(block, str) and block.startswith(TABLES):
            tables.append(read_table(block, parts))
        elif isinstance(block, str) and not block.startswith("statement: "):
            paragraphs.append(_as_line(block))
    return replace(
        untitled,
        title=_as_line(title),
        summary=paragraphs[0] if paragraphs else "",
        paragraphs=tuple(paragraphs[1:]),
        tables=tuple(tables),
        figures=tuple(block for block in blocks if isinstance(block, Figure)),
        statements=tuple(statements),
    )


def _as_line(block: str) -> str:
    """Returns a block of text as one line."""
    return " ".join(block.split())


def read_keys(block: str, template: str) -> dict[str, list[str]]:
    """Returns the values in a block of lines `name: value`, by name. A line without a name
    continues the value before it. Raises TextError if the first line has no name."""
    values: dict[str, list[str]] = {}
    key = ""
    for line in filter(str.strip, block.splitlines()):
        match = KEY.match(line)
        if match:
            key = match[1]
            values.setdefault(key, []).append(line[match.end() :].strip())
        elif key:
            values[key][-1] += f" {line.strip()}"
        else:
            raise TextError(f"{template}: {line!r} is no line of a head")
    return values


def _read_statement(block: str, template: str) -> Statement:
    """Reads a source's statement and the result for it from a block of lines; raises TextError if
    the block names none of the sources."""
    keys = {name: " ".join(lines) for name, lines in read_keys(block, template).items()}
    source = next(
        (name for name in CITED_SOURCES if keys["statement"].startswith(f"{name}, ")), None
    )
    if source is None:
        raise TextError(
            f"{template}: {keys['statement']!r} names none of {', '.join(CITED_SOURCES)}"
        )
    return Statement(
        source=source,
        place=keys["statement"][len(source) + 2 :],
        text=keys["says"],
        said=keys["value"],
        ours=keys["ours"],
        verdict=cast(StatementVerdict, keys["verdict"]),
        why=keys.get("why", ""),
        finding=keys.get("shown by", ""),
    )
