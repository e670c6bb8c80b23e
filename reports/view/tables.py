"""Tables, and lines for a terminal, as templates of reports/templates write them, with what every
template may use: filters, and functions that make cells, figures and statements.

    table: The caption               or `folded table`, which is shown on a click, or
                                     `filtered table`, whose rows and columns readers choose
    | method | error |               the heads, then the rows
    | {{ method(name) }} | {{ value(error, 2) }} |
    note: What stands below it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from plumbob.reports.view import notation, palette, plotly_figure
from plumbob.reports.view.content import Cell, Figure, Statement, Table, value
from plumbob.reports.view.records import PairVerdict
from plumbob.reports.view.sources import as_printed

if TYPE_CHECKING:
    from jinja2 import Environment

TEMPLATES = Path(__file__).parents[1] / "templates"
BAR = re.compile(r"(?<!\\)\|")
UNITS = MappingProxyType(
    {"µm": 1e6, "mm": 1e3, "nm": 1e9, "cm": 1e2, "%": 1e2, "ms": 1e3, "µs": 1e6, "kW": 1e-3}
)


@dataclass(frozen=True)
class Parts:
    """Cells, figures and statements that a text being filled has made, which it has places of."""

    made: dict[str, Cell | Figure | Statement] = field(default_factory=dict)  # by their places

    def held(self, part: Cell | Figure | Statement) -> str:
        """The place of a part, as text."""
        place = f"\x02{len(self.made)}\x03"
        self.made[place] = part
        return place


def table(template: str, **values: Any) -> Table:
    """The table that a template writes of values."""
    parts = Parts()
    return table_of(filled_text(f"tables/{template}", parts, values).strip(), parts)


def table_or_none(template: str, **values: Any) -> Table | None:
    """The same; None where it has no rows."""
    written = table(template, **values)
    return written if written.rows else None


def figures(template: str, **values: Any) -> tuple[Figure, ...]:
    """The figures that a template makes of values; the template's text is dropped."""
    parts = Parts()
    filled_text(f"figures/{template}", parts, values)
    return tuple(part for part in parts.made.values() if isinstance(part, Figure))


def lines(template: str, **values: Any) -> list[str]:
    """The lines for a terminal that a template writes of values."""
    text = filled_text(f"terminal/{template}", Parts(), values).rstrip("\n")
    return [line.rstrip() for line in text.split("\n")] if text else []


def filled_text(template: str, parts: Parts, values: dict[str, Any]) -> str:
    """A template's text, filled with values, and with the places of `parts` that it makes."""
    return _texts().get_template(f"{template}.md").render(_functions(parts) | values)


def paragraphs(template: str, **values: Any) -> tuple[str, ...]:
    """The paragraphs of a page that a template writes of values."""
    blocks = filled_text(f"pages/{template}", Parts(), values).split("\n\n")
    return tuple(" ".join(block.split()) for block in blocks if block.strip())


def table_of(block: str, parts: Parts) -> Table:
    """A table of a text: its caption, heads, rows and note."""
    lines: list[str] = []
    for line in map(str.strip, block.splitlines()):
        if line.startswith(("|", "note: ")) or not lines:
            lines.append(line)
        else:
            lines[-1] += f" {line}"
    note = lines.pop()[6:] if lines[-1].startswith("note: ") else ""
    caption = lines[0].partition(": ")[2]
    heads, *rows = [_cells(line, parts.made) for line in lines[1:]]
    kind = lines[0].partition("table: ")[0].strip()
    texts = tuple(cell.text for cell in heads)
    return Table(caption, texts, tuple(rows), note, kind == "folded", kind == "filtered")


def _cells(line: str, made: Mapping[str, Cell | Figure | Statement]) -> tuple[Cell, ...]:
    """The cells between the bars of a line; what is text becomes a cell of text."""
    texts = BAR.split(line) if "\\|" in line else line.split("|")
    return tuple(
        cell if isinstance(cell := made.get(text), Cell) else Cell(text.replace("\\|", "|"))
        for text in map(str.strip, texts[1:-1])
    )


def environment(templates: Path, **options: Any) -> Environment:
    """An environment that reads the templates of a folder, with further options of jinja2's."""
    import jinja2

    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(templates),
        # kept between processes, apart by the options: half a second of a report
        bytecode_cache=jinja2.FileSystemBytecodeCache(pattern=f"plumbob-{options}-%s"),
        undefined=jinja2.StrictUndefined,
        optimized=False,  # folding constants takes longer than it saves
        auto_reload=False,
        trim_blocks=True,
        lstrip_blocks=True,
        extensions=("jinja2.ext.do",),
        **options,
    )


@cache
def _texts() -> Environment:
    """The environment of the texts, with the filters for numbers and names."""
    texts = environment(TEMPLATES)
    texts.filters |= {
        "number": notation.number,  # 0.0123
        "relative": notation.relative,  # 1.23 %
        "percent": notation.percent,  # 12 %: a whole number of them
        "short": notation.short,  # 1e-4: a step
        "step": notation.step,  # 1e-4 s, or rtol 1e-9
        "seconds": notation.seconds,  # 12 ms
        "metres": notation.metres,  # 1.2 mm, two digits
        "real_time_factor": notation.real_time_factor,  # 123, of ns for a simulated second
        "times_real": notation.times_real,  # 123×
        "in_cell": lambda text: BAR.sub(r"\\|", text),  # whose bars end no cell
        "plural": notation.plural,  # 3 feet
        "unit": in_unit,  # 12 µm
        "scene": lambda name: name.partition("/")[2],
        "engine": lambda name: name.partition("/")[0],
        "anchor": lambda name: name.replace("/", "-"),  # the id of a scene's place
    }
    return texts


def in_unit(amount: float, unit: str, digits: int = 3) -> str:
    """An amount in SI units, or relative, in a smaller unit."""
    return f"{notation.number(UNITS[unit] * amount, digits)} {unit}"


def verdict_cell(judged: PairVerdict, link: str = "") -> Cell:
    """A verdict, coloured, and marked as known limit or as unexpected."""
    text = judged.verdict.replace("-", " ")
    hint = judged.reason or "as predicted, or within its bound"
    if judged.mark:
        text += f" ({judged.mark})"
        hint += f"; expected {judged.expected}"
        hint += f": {judged.declared}" if judged.declared else ""
    kind = f"{judged.verdict} surprise" if judged.mark == "unexpected" else judged.verdict
    return Cell(text, kind, hint, link)


def _functions(parts: Parts) -> dict[str, Any]:
    """The functions that make parts of a text: cells, figures and statements, each with its
    place."""

    def held(make: Callable[..., Cell | Figure | Statement]) -> Callable[..., str]:
        return lambda *values, **named: parts.held(make(*values, **named))

    return {
        "cell": held(Cell),
        "made": parts.held,  # a part that is made already
        "value": held(value),
        "right": held(lambda text: Cell(text, "number")),
        "verdict": held(verdict_cell),
        "method": held(lambda name: Cell(name, "method")),
        "plain_method": held(lambda name: Cell(name, "name")),
        "figure": held(plotly_figure.figure),
        "over_time": held(plotly_figure.over_time),
        "as_printed": held(as_printed),
        "curve": plotly_figure.curve,
        "marks": plotly_figure.marks,
        "heat": plotly_figure.heat,
        "linear": plotly_figure.linear,
        "logarithmic": plotly_figure.logarithmic,
        "spacious": plotly_figure.spacious,
        "positive": plotly_figure.positive,
        "colours": palette,  # colours.BLUE, colours.OF_METHODS[name]
    }
