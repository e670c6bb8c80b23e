"""Findings and galleries as their templates write them: words, tables, figures, statements.

A template of reports/templates is filled with stored numbers, by their names, and its text read in
blocks, which an empty line separates:

    judgement: confirmed             the head: lines of `name: value`, a `command` for each command
    command: plumbob solve {{ scene }}

    # The title

    The summary; then further paragraphs, whose lines are joined.

    table: The caption               or `folded table`, which is shown on a click
    | method | error |               the heads, then the rows
    | {{ method(name) }} | {{ value(error, 2) }} |
    note: What stands below it.

    statement: Chernousko 2020, (22)
    says: ...  value: ...  ours: ...  verdict: holds  why: ...  shown by: (each on a line)

    statements as a table            all of them, where this stands

    {{ figure("Title", "Caption.", [curve(times, errors, name="...")], linear("t"), linear("e")) }}

Filters are those of `_environment`, functions those of `_functions`; a macro of another file gets
all numbers as `numbers`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, cast

from plumbob.engines.study.results import Analysed
from plumbob.reports.view import notation, palette, traces
from plumbob.reports.view.content import (
    Cell,
    Claim,
    Figure,
    Finding,
    Statement,
    StatementVerdict,
    Table,
    row,
    value,
)
from plumbob.reports.view.overview import SOURCES
from plumbob.reports.view.sources import as_printed, stated

if TYPE_CHECKING:
    from jinja2 import Environment

TEMPLATES = Path(__file__).parents[1] / "templates"
KEY = re.compile(r"([a-z][a-z ]*): ?")
HELD = re.compile(r"\x02(\d+)\x03")  # the place of a part that is no text
BAR = re.compile(r"(?<!\\)\|")
UNITS = MappingProxyType(
    {"µm": 1e6, "mm": 1e3, "nm": 1e9, "cm": 1e2, "%": 1e2, "ms": 1e3, "µs": 1e6, "kW": 1e-3}
)


class TextError(ValueError):
    """A template whose text cannot be read."""


@dataclass(frozen=True)
class _Parts:
    """Cells, figures and statements that a text being filled has made, which it has places of."""

    made: list[Cell | Figure | Statement] = field(default_factory=list)

    def held(self, part: Cell | Figure | Statement) -> str:
        """The place of a part, as text."""
        self.made.append(part)
        return f"\x02{len(self.made) - 1}\x03"

    def at(self, text: str) -> Cell | Figure | Statement | None:
        """The part whose place is this text; None for other text."""
        place = HELD.fullmatch(text)
        return self.made[int(place[1])] if place else None


def findings_of(analysis: Analysed) -> tuple[Finding, ...]:
    """The finding, the galleries, or the figures and tables of a hard scene, that a template writes
    of stored numbers; raises jinja2.UndefinedError where the template needs numbers that are not
    stored, and TextError."""
    claims = tuple(Claim(text, holds) for text, holds in analysis.claims)
    return written(analysis.template, analysis.numbers, claims)


def written(
    template: str, numbers: Mapping[str, Any], claims: tuple[Claim, ...] = ()
) -> tuple[Finding, ...]:
    """The same of a template by its name, and numbers: one for each title in its text."""
    parts = _Parts()
    source = _environment().get_template(f"{template}.md")
    text = source.render(_functions(parts) | {"numbers": numbers} | dict(numbers))
    head, *sections = re.split(r"^# ", text.strip(), flags=re.MULTILINE)
    keys = _keys(head, template)
    name = keys.get("name", [template.rpartition("/")[2].replace("_", "-")])[0]
    judgement, commands = keys.get("judgement", [""])[0], tuple(keys.get("command", ()))
    empty = Finding(name, "", judgement, "", commands=commands, claims=claims)
    return tuple(_filled(empty, section, template, parts) for section in sections)


def _filled(empty: Finding, section: str, template: str, parts: _Parts) -> Finding:
    """A finding with the title, the paragraphs and the parts of a section of text."""
    title, *blocks = re.split(r"\n(?:[ \t]*\n)+", section.strip())
    paragraphs, figures, statements = list[str](), list[Figure](), list[Statement]()
    tables = list[Table | None]()
    for block in map(str.strip, blocks):
        part = parts.at(block)
        if isinstance(part, Figure):
            figures.append(part)
        elif isinstance(part, Statement):
            statements.append(part)
        elif block.startswith(("table: ", "folded table: ")):
            tables.append(_table(block, parts))
        elif block == "statements as a table":
            tables.append(None)
        elif block.startswith("statement: "):
            statements.append(_statement(block, template))
        elif block:
            paragraphs.append(_line(block))
    return replace(
        empty,
        title=_line(title),
        summary=paragraphs[0] if paragraphs else "",
        paragraphs=tuple(paragraphs[1:]),
        tables=tuple(table or stated(statements) for table in tables),
        figures=tuple(figures),
        statements=tuple(statements),
    )


def _line(block: str) -> str:
    """A block as one line."""
    return " ".join(block.split())


def _keys(block: str, template: str) -> dict[str, list[str]]:
    """The values of a block of lines `name: value`, by name; a line without one goes on."""
    values: dict[str, list[str]] = {}
    key = ""
    for line in filter(str.strip, block.splitlines()):
        if (match := KEY.match(line)) is not None:
            key = match[1]
            values.setdefault(key, []).append(line[match.end() :].strip())
        elif key:
            values[key][-1] += f" {line.strip()}"
        else:
            raise TextError(f"{template}: {line!r} is no line of a head")
    return values


def _table(block: str, parts: _Parts) -> Table:
    """A table: its caption, heads, rows and note."""
    lines: list[str] = []
    for line in map(str.strip, block.splitlines()):
        if line.startswith(("|", "note: ", "table: ", "folded table: ")) or not lines:
            lines.append(line)
        else:
            lines[-1] += f" {line}"
    note = lines.pop()[6:] if lines[-1].startswith("note: ") else ""
    caption = lines[0].partition(": ")[2]
    heads, *rows = [list(_cells(line, parts)) for line in lines[1:]]
    cells = tuple(row(*line) for line in rows)
    return Table(caption, tuple(map(str, heads)), cells, note, lines[0].startswith("folded"))


def _cells(line: str, parts: _Parts) -> Iterator[str | Cell]:
    """The cells between the bars of a line."""
    for text in BAR.split(line.strip())[1:-1]:
        stripped = text.strip().replace("\\|", "|")
        cell = parts.at(stripped)
        yield cell if isinstance(cell, Cell) else stripped


def _statement(block: str, template: str) -> Statement:
    """A source's statement and the result for it."""
    keys = {name: " ".join(lines) for name, lines in _keys(block, template).items()}
    source = next((name for name in SOURCES if keys["statement"].startswith(f"{name}, ")), None)
    if source is None:
        raise TextError(f"{template}: {keys['statement']!r} names none of {', '.join(SOURCES)}")
    return Statement(
        source,
        keys["statement"][len(source) + 2 :],
        keys["says"],
        keys["value"],
        keys["ours"],
        cast(StatementVerdict, keys["verdict"]),
        keys.get("why", ""),
        keys.get("shown by", ""),
    )


@cache
def _environment() -> Environment:
    """The environment that reads the templates, with the filters for numbers and names."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        undefined=jinja2.StrictUndefined,
        extensions=["jinja2.ext.do"],
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "number": notation.number,  # 0.0123
        "relative": notation.relative,  # 1.23 %
        "percent": notation.percent,  # 12 %: a whole number of them
        "short": notation.short,  # 1e-4: a step
        "seconds": notation.seconds,  # 12 ms
        "metres": notation.metres,  # 1.2 mm, two digits
        "duration": notation.duration,  # 2 ms
        "in_cell": lambda text: BAR.sub(r"\\|", text),  # whose bars end no cell
        "plural": notation.plural,  # 3 feet
        "unit": in_unit,  # 12 µm
        "scene": lambda name: name.partition("/")[2],
        "order": order_text,
    }
    return environment


def in_unit(amount: float, unit: str, digits: int = 3) -> str:
    """An amount in SI units, or relative, in a smaller unit."""
    return f"{notation.number(UNITS[unit] * amount, digits)} {unit}"


def order_text(order: Mapping[str, float] | None) -> str:
    """An order with its confidence interval; a dash where there is none."""
    if not order:
        return "–"
    return f"{order['slope']:.3f} [{order['low']:.3f}, {order['high']:.3f}]"


def _functions(parts: _Parts) -> dict[str, Any]:
    """What makes a part of a text: cells, figures and statements, each with its place."""

    def held(make: Callable[..., Cell | Figure | Statement]) -> Callable[..., str]:
        return lambda *values, **named: parts.held(make(*values, **named))

    return {
        "cell": held(Cell),
        "value": held(value),
        "right": held(lambda text: Cell(text, "number")),
        "method": held(lambda name: Cell(name, "method")),
        "plain_method": held(lambda name: Cell(name, "name")),
        "figure": held(traces.figure),
        "over_time": held(traces.over_time),
        "as_printed": held(as_printed),
        "curve": traces.curve,
        "marks": traces.marks,
        "heat": traces.heat,
        "linear": traces.linear,
        "logarithmic": traces.logarithmic,
        "positive": traces.positive,
        "colours": palette,  # colours.BLUE, colours.OF_METHODS[name]
    }
