"""The parts of a page: tables, figures, findings, and the section of one system."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from plumbob.reports.view.notation import number

Trace = Mapping[str, Any]  # a curve, bars or a map, as plotly takes it
Layout = Mapping[str, Any]  # of a figure, or of one of its axes
StatementVerdict = Literal["holds", "corrected", "refuted", "extended"]


class Cell(NamedTuple):
    """A place in a table: its text, its looks, and what a hover shows."""

    text: str
    kind: str = ""  # a verdict, or "number", "method": how it looks
    hint: str = ""  # shown on hover
    link: str = ""  # the id of the place it leads to
    span: int = 1  # columns


@dataclass(frozen=True)
class Table:
    """A table: a caption, the heads of its columns, and rows of cells."""

    caption: str
    heads: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""
    folded: bool = False  # shown on a click
    filtered: bool = False  # its rows and columns are chosen by a filter above the tables


@dataclass(frozen=True)
class Figure:
    """A plot as plotly takes it: traces and a layout, with a title and a caption of its own."""

    title: str
    caption: str
    traces: tuple[Trace, ...]
    layout: Layout
    height: int = 340  # [px]
    wide: bool = False


@dataclass(frozen=True)
class Statement:
    """A source's statement and the result for it; a row of the page's table of the sources."""

    source: str  # its key in the citations: an author and a year
    place: str  # in the source: an equation, a figure, a section
    text: str
    said: str  # the source's value, formula or word
    ours: str  # computed or measured
    verdict: StatementVerdict
    why: str = ""
    finding: str = ""  # that shows it, where it is another than the one that has the statement


@dataclass(frozen=True)
class Claim:
    """A check that a measured figure supports a finding's text: its words say why that would not
    hold, and whether it does."""

    text: str
    holds: bool


@dataclass(frozen=True)
class Finding:
    """Something that measuring showed: in a sentence, in full, and the commands that repeat it."""

    name: str  # unique within the page: what links lead to
    title: str
    judgement: str  # a word or two: "refuted", "confirmed"
    summary: str  # one sentence
    paragraphs: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    figures: tuple[Figure, ...] = ()
    commands: tuple[str, ...] = ()
    statements: tuple[Statement, ...] = ()  # of the sources that this finding judges
    claims: tuple[Claim, ...] = ()  # what its words rest on, of the stored study


def value(amount: float | None, digits: int = 3) -> Cell:
    """A cell with a number of so many significant digits; a dash where there is none."""
    return Cell("–" if amount is None else number(amount, digits), "number")
