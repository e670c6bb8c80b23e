"""Tables, figures, paragraphs and terminal lines written by the templates in reports/templates, and
the filters and functions that these templates may use. The text of a table reads:

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

from plumbob.reports.records import notation
from plumbob.reports.view import palette, plotly_figure
from plumbob.reports.view.content import Cell, Figure, Statement, Table, value
from plumbob.reports.view.sources import as_printed

if TYPE_CHECKING:
    from jinja2 import Environment

    from plumbob.reports.records.page_records import PairVerdict

TABLE_TEMPLATES = Path(__file__).parents[1] / "templates"
BAR = re.compile(r"(?<!\\)\|")
UNIT_FACTORS = MappingProxyType(
    {"µm": 1e6, "mm": 1e3, "nm": 1e9, "cm": 1e2, "%": 1e2, "ms": 1e3, "µs": 1e6, "kW": 1e-3}
)


@dataclass(frozen=True)
class TemplateParts:
    """The cells, figures and statements that a template makes. The template's text holds a
    placeholder for each."""

    made: dict[str, Cell | Figure | Statement] = field(default_factory=dict)  # by placeholder

    def store(self, part: Cell | Figure | Statement) -> str:
        """Stores a part and returns its placeholder in the text."""
        placeholder = f"\x02{len(self.made)}\x03"
        self.made[placeholder] = part
        return placeholder


def table(template: str, **values: Any) -> Table:
    """Returns the table that the template `tables/TEMPLATE.md` writes from `values`."""
    parts = TemplateParts()
    return read_table(fill_text(f"tables/{template}", parts, values).strip(), parts)


def table_or_none(template: str, **values: Any) -> Table | None:
    """Returns the table that the template writes from `values`; None if the table has no rows."""
    filled_table = table(template, **values)
    return filled_table if filled_table.rows else None


def figures(template: str, **values: Any) -> tuple[Figure, ...]:
    """Returns the figures that the template `figures/TEMPLATE.md` makes from `values`; the text of
    the template is dropped."""
    parts = TemplateParts()
    fill_text(f"figures/{template}", parts, values)
    return tuple(part for part in parts.made.values() if isinstance(part, Figure))


def terminal_lines(template: str, **values: Any) -> list[str]:
    """Returns the lines that the template `terminal/TEMPLATE.md` writes from `values`."""
    text = fill_text(f"terminal/{template}", TemplateParts(), values).rstrip("\n")
    return [line.rstrip() for line in text.split("\n")] if text else []


def fill_text(template: str, parts: TemplateParts, values: dict[str, Any]) -> str:
    """Returns the text of a template filled with `values`. Each cell, figure or statement that the
    template makes is stored in `parts`, and the text holds its placeholder."""
    return _texts().get_template(f"{template}.md").render(_functions(parts) | values)


def paragraphs(template: str, **values: Any) -> tuple[str, ...]:
    """Returns the paragraphs that the template `pages/TEMPLATE.md` writes from `values`, each as
    one line."""
    blocks = fill_text(f"pages/{template}", TemplateParts(), values).split("\n\n")
    return tuple(" ".join(block.split()) for block in blocks if block.strip())


def read_table(block: str, parts: TemplateParts) -> Table:
    """Returns the table that a block of text describes:

        folded table: Caption, which may go on in the next line
        | head | head |
        | cell | cell |
        note: A note.

    The first word is optional. `parts` holds cells that stand in the text as placeholders."""
    joined: list[str] = []
    for line in map(str.strip, block.splitlines()):
        if line.startswith(("|", "note: ")) or not joined:
            joined.append(line)
        else:
            joined[-1] += f" {line}"
    note = joined.pop().removeprefix("note: ") if joined[-1].startswith("note: ") else ""
    heads, *rows = [_cells(line, parts.made) for line in joined[1:]]
    kind = joined[0].partition("table: ")[0].strip()
    return Table(
        caption=joined[0].partition(": ")[2],
        heads=tuple(cell.text for cell in heads),
        rows=tuple(rows),
        note=note,
        folded=kind == "folded",
        filtered=kind == "filtered",
    )


def _cells(line: str, made: Mapping[str, Cell | Figure | Statement]) -> tuple[Cell, ...]:
    """Returns the cells between the bars of a line. A placeholder becomes the cell in `made`; any
    other text becomes a plain cell."""
    texts = BAR.split(line) if "\\|" in line else line.split("|")
    cells = list[Cell]()
    for text in map(str.strip, texts[1:-1]):
        part = made.get(text)
        cells.append(part if isinstance(part, Cell) else Cell(text.replace("\\|", "|")))
    return tuple(cells)


def template_environment(templates: Path, **options: Any) -> Environment:
    """Returns a jinja2 environment that reads the templates of a folder; `options` are further
    options of jinja2."""
    import jinja2

    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(templates),
        # Compiled templates are kept between processes, one cache for each set of options: this
        # saves half a second of a report.
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
    """Returns the environment of the text templates, with filters for numbers and names."""
    texts = template_environment(TABLE_TEMPLATES)
    texts.filters |= {
        "number": notation.number,  # 0.0123
        "relative": notation.relative,  # 1.23 %
        "percent": notation.percent,  # 12 %: a whole number of them
        "short": notation.short,  # 1e-4: a step
        "shortest": notation.shortest,  # 0.3: a parameter, or several
        "step": notation.step,  # 1e-4 s, or rtol 1e-9
        "seconds": notation.seconds,  # 12 ms
        "milliseconds": notation.milliseconds,  # 7.77 for 7.77e6 ns
        "metres": notation.metres,  # 1.2 mm, two digits
        "factor": notation.factor,  # 9.8, 110, 80,000
        "real_time_factor": notation.real_time_factor,  # 123 for 8.13e6 ns a second
        "times_real": notation.times_real,  # 123×
        "in_cell": lambda text: BAR.sub(r"\\|", text),  # bars escaped, so that they end no cell
        "plural": notation.plural,  # 3 feet
        "unit": in_unit,  # 12 µm
        "scene": lambda name: name.partition("/")[2],
        "engine": lambda name: name.partition("/")[0],
        "anchor": lambda name: name.replace("/", "-"),  # the id of a scene's place
    }
    return texts


def in_unit(amount: float, unit: str, digits: int = 3) -> str:
    """Returns an amount, given in SI units or as a fraction, as text in another unit of
    `UNIT_FACTORS`."""
    return f"{notation.number(UNIT_FACTORS[unit] * amount, digits)} {unit}"


def verdict_cell(judged: PairVerdict, link: str = "") -> Cell:
    """Returns the cell of a verdict, coloured by the verdict and marked as known limit or
    unexpected. A hover shows the reason."""
    text = judged.verdict.replace("-", " ")
    hint = judged.reason or "as predicted, or within its bound"
    if judged.mark:
        text += f" ({judged.mark})"
        hint += f"; expected {judged.expected}"
        hint += f": {judged.declared}" if judged.declared else ""
    kind = f"{judged.verdict} surprise" if judged.mark == "unexpected" else judged.verdict
    return Cell(text, kind, hint, link)


def _functions(parts: TemplateParts) -> dict[str, Any]:
    """Returns the functions that a template may call, by name. A function that makes a cell, a
    figure or a statement stores it in `parts` and returns its placeholder."""

    def stored(make: Callable[..., Cell | Figure | Statement]) -> Callable[..., str]:
        """Returns a function that stores what `make` returns, and returns its placeholder."""
        return lambda *values, **named: parts.store(make(*values, **named))

    return {
        "cell": stored(Cell),
        "made": parts.store,  # stores a part that is made already
        "value": stored(value),
        "right": stored(lambda text: Cell(text, "number")),
        "verdict": stored(verdict_cell),
        "method": stored(lambda name: Cell(name, "method")),
        "plain_method": stored(lambda name: Cell(name, "name")),
        "figure": stored(plotly_figure.figure),
        "over_time": stored(plotly_figure.over_time),
        "as_printed": stored(as_printed),
        "curve": plotly_figure.curve,
        "prediction": plotly_figure.prediction,
        "marks": plotly_figure.marks,
        "heat": plotly_figure.heat,
        "linear": plotly_figure.linear,
        "logarithmic": plotly_figure.logarithmic,
        "spacious": plotly_figure.spacious,
        "positive": plotly_figure.positive_magnitudes,
        "colours": palette,  # colours.BLUE, colours.OF_METHODS[name]
    }
