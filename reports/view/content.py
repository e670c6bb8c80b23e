"""The parts of a page: cells, tables, figures, statements, claims and findings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from plumbob.reports.records.claim import Claim
from plumbob.reports.records.exact_numbers import ExactNumbers
from plumbob.reports.records.notation import number

PlotlyTrace = Mapping[str, Any]  # a curve, bars or a map in plotly's format
PlotlyLayout = Mapping[str, Any]  # properties of a figure, or of one axis, in plotly's format
StatementVerdict = Literal["holds", "corrected", "refuted", "extended"]


class Cell(NamedTuple):
    """A cell of a table."""

    text: str
    kind: str = ""  # style of the cell: a verdict, "number", "method", …
    hint: str = ""  # text shown on hover
    link: str = ""  # id that the cell links to
    span: int = 1  # number of columns


@dataclass(frozen=True)
class Table:
    """A table with a caption, the heads of its columns, rows of cells and a note below."""

    caption: str
    heads: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""
    folded: bool = False  # whether the table is hidden until a click
    filtered: bool = False  # whether the filter above the tables chooses its rows and columns


@dataclass(frozen=True)
class Figure:
    """A figure: traces and a layout in plotly's format, with a title and a caption."""

    title: str
    caption: str
    traces: tuple[PlotlyTrace, ...]
    layout: PlotlyLayout
    height: int = 340  # [px]
    wide: bool = False


@dataclass(frozen=True)
class Statement:
    """A statement of a source and the result for it; a row in the page's table of sources."""

    source: str  # key of the source in the citations: an author and a year
    place: str  # equation, figure or section of the source
    text: str
    said: str  # value, formula or word in the source
    ours: str  # computed or measured value
    verdict: StatementVerdict
    why: str = ""  # reason of the verdict
    finding: str = ""  # name of the finding that shows the result, if another finding shows it


@dataclass(frozen=True)
class Finding:
    """A result of the measurements: a summary, the full text, tables, figures, and the commands
    that repeat it."""

    name: str  # id for links, unique within the page
    title: str
    judgement: str  # a word or two: "refuted", "confirmed"
    summary: str  # one sentence
    paragraphs: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    figures: tuple[Figure, ...] = ()
    commands: tuple[str, ...] = ()
    statements: tuple[Statement, ...] = ()  # statements of sources that the finding judges
    key: int = 0  # place among the key findings on the index, from 1; 0: no key finding
    claims: tuple[Claim, ...] = ()  # checks that the stored numbers support the text
    exact: ExactNumbers | None = None  # shipped numbers that the text shows, if it shows any


def value(amount: float | None, digits: int = 3) -> Cell:
    """Returns a cell with a number of `digits` significant digits; a dash for None."""
    return Cell("–" if amount is None else number(amount, digits), "number")
