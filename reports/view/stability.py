"""The largest steps that hold, as lines of text and as a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from plumbob.engines.study.provenance import Provenance
from plumbob.reports.judge.stability import JudgedLimit
from plumbob.reports.view.content import Cell, Table, row
from plumbob.reports.view.notation import number
from plumbob.reports.view.page import filled, written

NAME = "stability.html"
HEADS = ("scene", "method", "limit", "predicted [s]", "holds [s]", "fails [s]", "verdict", "why")


def lines(judged: Sequence[JudgedLimit]) -> Iterator[str]:
    """A table, and below it what is unexpected."""
    rows = [HEADS, *map(_texts, judged)]
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    for cells in rows:
        padded = (f"{cell:<{width}}" for cell, width in zip(cells, widths, strict=True))
        yield "  ".join(padded).rstrip()
    for limit in judged:
        if limit.surprise:
            yield f"UNEXPECTED {limit.scene} {limit.method}: {limit.surprise}"


def write_page(judged: Sequence[JudgedLimit], provenance: Provenance, folder: Path) -> Path:
    """Write `stability.html` into `folder` and return its path; raises OSError."""
    return written(render(judged, provenance), folder, NAME)


def render(judged: Sequence[JudgedLimit], provenance: Provenance) -> str:
    """The page as HTML, in one file."""
    return filled("stability.html.jinja", table=table(judged), made=provenance)


def table(judged: Sequence[JudgedLimit]) -> Table:
    """A row a limit."""
    kinds = ("text", "name", "text", "number", "number", "number", "", "text")
    rows = []
    for limit in judged:
        cells = [Cell(text, kind) for text, kind in zip(_texts(limit), kinds, strict=True)]
        shown = limit.verdict if limit.verdict != "measured" else ""
        cells[6] = Cell(cells[6].text, shown, limit.surprise or limit.known)
        rows.append(row(*cells))
    return Table("The largest step that holds", HEADS, tuple(rows))


def _texts(of: JudgedLimit) -> tuple[str, ...]:
    """The cells of a limit."""
    limit, why = of.limit, of.why
    if limit is None:
        return of.scene, of.method, "none", "", "", "", "", why
    mark = " (UNEXPECTED)" if of.surprise else " (known)" if of.known else ""
    if limit.reason:
        why = f"{why}; predicted: {limit.reason}"
    return (
        of.scene,
        of.method,
        limit.kind,
        _step(limit.predicted, "none" if limit.predicted is not None else ""),
        _step(limit.holds, "–"),
        _step(limit.fails, "–"),
        f"{of.verdict}{mark}",
        why,
    )


def _step(step: float | None, instead: str) -> str:
    """A step with four digits; `instead` where it is none, or infinite."""
    return instead if step is None or step == float("inf") else number(step, 4)
