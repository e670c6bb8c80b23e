"""A table of results as columns: numpy arrays, CSV, a data frame, or a table for a paper."""

from __future__ import annotations

import csv
import io
import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array

SCHEMA_FILE = Path(__file__).parents[1] / "templates" / "columns.toml"
MISSING_INTEGER = -1
# A spreadsheet takes a text that begins with one of these for a formula.
FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
LATEX_ESCAPES = str.maketrans(
    {
        **{mark: f"\\{mark}" for mark in "&%$#_{}"},
        "~": r"\textasciitilde{}",
        "^": r"\textasciicircum{}",
        "\\": r"\textbackslash{}",
    }
)
WITHOUT_PANDAS = (
    "pandas is not installed: `pip install pandas`, or take the columns as they are"
)


@dataclass(frozen=True)
class ColumnMeaning:
    """The description of a column."""

    kind: str  # "text", "number", "integer" or "truth"
    unit: str  # "unit": the unit stands in the column of that name
    meaning: str


@dataclass(frozen=True)
class Columns:
    """A table of results: `table["error"]` is the column `error`, a numpy array.

    `meanings` says for each column its kind, unit and meaning. `len(table)` is the number of
    rows."""

    name: str  # name of the table in the schema
    arrays: Mapping[str, Array]
    meanings: Mapping[str, ColumnMeaning]
    paper: tuple[str, ...] = ()  # columns of the table for a paper
    about: str = field(default="", repr=False)  # what a row is

    def __getitem__(self, name: str) -> Array:
        if name not in self.arrays:
            raise ParameterError("column", name, f"one of {', '.join(self.arrays)}")
        return self.arrays[name]

    def __len__(self) -> int:
        return len(next(iter(self.arrays.values()), ()))

    def __repr__(self) -> str:
        return f"<{self.name}: {len(self)} rows of {', '.join(self.arrays)}>"

    def where(self, **values: Any) -> Columns:
        """Returns the rows in which each named column has the given value."""
        kept = np.ones(len(self), bool)
        for name, value in values.items():
            kept &= self[name] == value
        arrays = {name: values[kept] for name, values in self.arrays.items()}
        return Columns(self.name, arrays, self.meanings, self.paper, self.about)

    def rows(self) -> Iterable[tuple[Any, ...]]:
        """Returns the rows as tuples of texts, numbers and truth values; None if not known."""
        columns = [_plain_values(values) for values in self.arrays.values()]
        return zip(*columns, strict=True)

    def to_csv(self, path: str | Path | None = None) -> str:
        """Returns the table as CSV (RFC 4180, UTF-8), with a first line of names; writes it to a
        new file if a `path` is given. Numbers have all their digits; a value that is not known is
        empty. A text that a spreadsheet would take for a formula gets an apostrophe in front.
        Raises ParameterError if the file exists or cannot be written."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\r\n")
        writer.writerow(self.arrays)
        writer.writerows([_csv_cell(value) for value in row] for row in self.rows())
        if path is not None:
            try:
                with open(path, "x", encoding="utf-8", newline="") as file:
                    file.write(text.getvalue())
            except OSError as error:
                wanted = f"a new file in a folder that can be written to ({error.strerror})"
                raise ParameterError("path", str(path), wanted) from None
        return text.getvalue()

    def to_pandas(self) -> Any:
        """Returns the table as a `pandas.DataFrame`; raises ImportError, which says what to
        install, if pandas is not there. Units are in `attrs["units"]`."""
        try:
            from pandas import DataFrame
        except ImportError:
            raise ImportError(WITHOUT_PANDAS) from None
        frame = DataFrame(dict(self.arrays))
        frame.attrs["units"] = {name: meaning.unit for name, meaning in self.meanings.items()}
        return frame

    def to_latex(self, columns: Sequence[str] = ()) -> str:
        """Returns the table as a LaTeX `tabular`, with numbers to three digits: the named columns,
        or those that suit a paper."""
        names = tuple(columns) or self.paper or tuple(self.arrays)
        chosen = [(_plain_values(self[name]), self.meanings[name]) for name in names]
        aligned = "".join("l" if meaning.kind == "text" else "r" for _, meaning in chosen)
        heads = [_latex_head(name, self.meanings[name].unit) for name in names]
        lines = [_latex_line(heads), r"\hline"]
        for row in zip(*(values for values, _ in chosen), strict=True):
            lines.append(_latex_line(map(_latex_cell, row)))
        body = "\n".join(lines)
        return f"\\begin{{tabular}}{{{aligned}}}\n{body}\n\\end{{tabular}}\n"


@cache
def table_schemas() -> Mapping[str, Mapping[str, Any]]:
    """Returns {table: its `about`, `paper` and `columns`}, as reports/templates/columns.toml
    describes them."""
    tables = tomllib.loads(SCHEMA_FILE.read_text("utf-8"))
    return MappingProxyType(tables)


def columns_of(
    name: str,
    rows: Iterable[Mapping[str, Any]],
    further: Mapping[str, ColumnMeaning] = MappingProxyType({}),
) -> Columns:
    """Returns the table `name` of the schema from its rows, {column: value}, with `further` columns
    at its end. A value that a row lacks, or that is None, is not known."""
    schema = table_schemas()[name]
    meanings = {key: ColumnMeaning(*entry) for key, entry in schema["columns"].items()}
    meanings |= further
    listed = list(rows)
    arrays = {
        key: _array(meaning.kind, [row.get(key) for row in listed])
        for key, meaning in meanings.items()
    }
    return Columns(name, arrays, meanings, tuple(schema["paper"]), schema["about"])


def _array(kind: str, values: Sequence[Any]) -> Array:
    """Returns values of a kind as an array."""
    if kind == "text":
        return np.array(["" if value is None else str(value) for value in values], dtype=str)
    if kind == "integer":
        known = [MISSING_INTEGER if value is None else int(value) for value in values]
        return np.array(known, dtype=np.int64)
    if kind == "truth":
        return np.array([bool(value) for value in values], dtype=bool)
    numbers = [math.nan if value is None else float(value) for value in values]
    return np.array(numbers, dtype=np.float64)


def _plain_values(values: Array) -> list[Any]:
    """Returns the values of a column as Python values; None for one that is not known."""
    if values.dtype.kind == "f":
        return [None if math.isnan(value) else value for value in values.tolist()]
    if values.dtype.kind == "i":
        return [None if value == MISSING_INTEGER else value for value in values.tolist()]
    return list(values.tolist())


def _csv_cell(value: Any) -> str:
    """Returns a value as the text of a CSV cell."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        line = value.replace("\r", " ").replace("\n", " ").replace("\0", "")
        return f"'{line}" if value.startswith(FORMULA_STARTS) else line
    return repr(value)


def _latex_head(name: str, unit: str) -> str:
    """Returns the head of a column for LaTeX: its name in words, with its unit."""
    words = name.replace("_", " ")
    return words.translate(LATEX_ESCAPES) + (f" [{unit}]" if unit not in ("", "unit") else "")


def _latex_cell(value: Any) -> str:
    """Returns a value as the text of a LaTeX cell."""
    if value is None:
        return "--"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (str, int)):
        return str(value).translate(LATEX_ESCAPES)
    if math.isinf(value):
        return r"$\infty$"
    text = f"{value:.3g}"
    mantissa, mark, exponent = text.partition("e")
    return f"${mantissa} \\cdot 10^{{{int(exponent)}}}$" if mark else f"${text}$"


def _latex_line(cells: Iterable[str]) -> str:
    """Returns the cells of a row as a line of a LaTeX table."""
    return " & ".join(cells) + r" \\"
