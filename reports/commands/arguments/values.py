"""Readers of command-line arguments: numbers, lists, intervals, and parameters as NAME=JSON."""

from __future__ import annotations

import argparse
import json
import math
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from plumbob.analytic.parameters import (
    ParameterError,
    changed_beyond,
    finite,
    non_negative,
    positive,
)
from plumbob.analytic.reference import Signals
from plumbob.models.registry import matching_scenes as find_scenes
from plumbob.models.registry import scene as find_scene
from plumbob.reports.view.own_files import check_replaceable

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from plumbob.engines.box import Side
    from plumbob.engines.method import Method
    from plumbob.engines.study.shard import Shard
    from plumbob.models.scene import Scene
    from plumbob.reports.columns.columns import Columns

T = TypeVar("T")
SHARD_TEXT = re.compile(
    r"([1-9][0-9]{0,3})/([1-9][0-9]{0,3})"
)  # array jobs have some thousands
REPRESENTABLE = "such that double precision holds the exact solution"


def number(name: str, text: str) -> float:
    """Returns `text` as a finite number. Raises ParameterError."""
    try:
        return finite(name, float(text))
    except ValueError:
        raise ParameterError(name, text, "a finite number") from None


def positive_number(name: str, text: str) -> float:
    """Returns `text` as a number above zero. Raises ParameterError."""
    return positive(name, number(name, text))


def non_negative_number(name: str, text: str) -> float:
    """Returns `text` as a number of zero or more. Raises ParameterError."""
    return non_negative(name, number(name, text))


def read_each(read: Callable[[str], T], texts: str | Sequence[str]) -> list[T]:
    """Returns the values that `read` gives for a list of texts, or for the parts of one text
    T,T,..."""
    parts = texts.split(",") if isinstance(texts, str) else texts
    return [read(part) for part in parts]


def count(name: str, text: str, least: int = 1) -> int:
    """Returns `text` as a whole number from `least` to 2^63 - 1. Raises ParameterError."""
    if not (
        text.isascii() and text.isdigit() and len(text) < 20 and least <= int(text) < 2**63
    ):
        raise ParameterError(name, text, f"a whole number, {least} or more")
    return int(text)


def shard(name: str, text: str) -> Shard:
    """Returns K/N as shard K of N, from 1 to N. Raises ParameterError."""
    from plumbob.engines.study.shard import Shard

    match = SHARD_TEXT.fullmatch(text)
    if not match or int(match[1]) > int(match[2]):
        raise ParameterError(name, text, "K/N, such as 2/5: part K of N parts, 1 to 9999")
    return Shard(int(match[1]), int(match[2]))


def fraction(name: str, text: str) -> float:
    """Returns a text such as 5% or 0.05 as a fraction of zero or more. Raises ParameterError."""
    try:
        value = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        value = math.nan
    if not 0.0 <= value < math.inf:
        raise ParameterError(name, text, "a percentage such as 5%, or a fraction: 0.05")
    return value


def changes(argument: str, texts: Sequence[str]) -> dict[str, Any]:
    """Returns texts NAME=JSON as a mapping from names to values. Raises ParameterError."""
    changed: dict[str, Any] = {}
    for entry in texts:
        name, equals, value = entry.partition("=")
        if not equals or not name:
            raise ParameterError(argument, entry, "NAME=JSON")
        try:
            changed[name] = json.loads(value)
        except (ValueError, RecursionError):
            raise ParameterError(name, value, "a JSON value, such as 9.8 or [1, 2]") from None
    return changed


def refuse_options(chosen: argparse.Namespace, names: Sequence[str], wanted: str) -> None:
    """Raises ParameterError if one of the options `names` is given. `wanted` is the end of the
    message: what the option must be."""
    for name in names:
        value = getattr(chosen, name)
        if value and value != "rest":
            option = "set" if name == "changes" else name.replace("_", " ")
            raise ParameterError(option, value, wanted)


def side(argument: str, text: str) -> Side:
    """Returns NAME=LO:HI or NAME=LO:HI:log as an interval of a parameter. Raises ParameterError."""
    return _read_side(argument, text, "NAME=LO:HI")[0]


def counted_side(argument: str, text: str) -> tuple[Side, int]:
    """Returns NAME=LO:HI:N or NAME=LO:HI:N:log as an interval of a parameter and the number N of
    its values. Raises ParameterError."""
    interval, number_of_values = _read_side(argument, text, "NAME=LO:HI:N")
    return interval, count(interval.name, number_of_values)


def _read_side(argument: str, text: str, form: str) -> tuple[Side, str]:
    """Returns the interval in a text of the given `form`, with :log at its end or without, and the
    last part of the text before :log. Raises ParameterError."""
    from plumbob.engines.box import Side

    name, _, bounds = text.partition("=")
    parts = bounds.split(":")
    logarithmic = parts[-1] == "log"
    if logarithmic:
        parts.pop()
    if not name or len(parts) != form.count(":") + 1:
        raise ParameterError(argument, text, f"{form}, or {form}:log")
    low, high = (number(name, part) for part in parts[:2])
    if low >= high:
        raise ParameterError(argument, text, "with the smaller value first")
    if logarithmic and low <= 0.0:
        raise ParameterError(argument, text, "above 0 where spaced by ratios")
    return Side(name, low, high, logarithmic), parts[-1]


def scenes(pattern: str, changed: Mapping[str, Any]) -> tuple[Scene, ...]:
    """Returns the scenes that a name or pattern means, with the parameters `changed`. Raises
    ParameterError."""
    with representable(changed):
        if any(mark in pattern for mark in "*?[,"):
            matching = find_scenes(pattern)
            if not changed:
                return matching
            return tuple(find_scene(scene.name, changed) for scene in matching)
        return (find_scene(pattern, changed),)


def html_file(name: str, text: str) -> Path:
    """Returns the path of an .html file that can be written. Raises ParameterError with the `name`
    of the option."""
    file = Path(text)
    check_replaceable(name, file)
    if file.suffix != ".html" or not os.access(file.parent, os.W_OK):
        raise ParameterError(name, text, "a file .html in a folder that can be written to")
    return file


@contextmanager
def workers(chosen: argparse.Namespace) -> Iterator[tuple[Executor | None, int]]:
    """Gives the executor of a Dask scheduler, or None if none is chosen, and the number of tasks
    that run at a time. Raises ParameterError."""
    if chosen.scheduler is None:
        yield None, chosen.jobs or os.cpu_count() or 1
        return
    if chosen.jobs is not None:
        raise ParameterError("jobs", chosen.jobs, "left out where --scheduler is given")
    from plumbob.engines.sweep.cluster import cluster

    with cluster(chosen.scheduler) as executor:
        yield executor


@contextmanager
def representable(
    changed: Mapping[str, Any], chosen: argparse.Namespace | None = None
) -> Iterator[None]:
    """Turns numerical errors of the exact solution into ParameterError: extreme values of the
    parameters `changed` overflow double precision. The message names these parameters. If all
    arguments are given as `chosen`, a ParameterError that names none of them is raised anew with
    the names of the changed parameters."""
    try:
        with np.errstate(all="ignore"):
            yield
    except ParameterError as error:
        if chosen is None or error.name in vars(chosen):
            raise
        raise error.due_to(changed) from None
    except (ArithmeticError, np.linalg.LinAlgError, RuntimeError) as error:
        if not changed:
            raise
        raise changed_beyond(changed, REPRESENTABLE) from error


def all_finite(changed: Mapping[str, Any], *answers: Signals) -> None:
    """Raises ParameterError, which names the parameters `changed`, if a number in the `answers` is
    not finite."""
    if not changed:
        return
    for signals in answers:
        if not all(np.isfinite(values).all() for values in signals.values()):
            raise changed_beyond(changed, REPRESENTABLE)


def show(
    chosen: argparse.Namespace,
    record: Any,
    template: str,
    /,
    *,
    columns: Callable[[], Columns] | None = None,
    **values: Any,
) -> None:
    """Prints `record` as JSON, or the table `columns` as CSV or LaTeX, if the user asks for that.
    Otherwise prints the lines that `template` makes of the `values`."""
    if as_table(chosen) and columns is not None:
        print_table(chosen, columns())
        return
    if chosen.json:
        print_json(record)
        return
    from plumbob.reports.view.tables import terminal_lines

    print(*terminal_lines(template, **values), sep="\n")


def as_table(chosen: argparse.Namespace) -> bool:
    """Returns whether the user asks for a table as CSV or LaTeX, in place of text or JSON."""
    return bool(getattr(chosen, "csv", False) or getattr(chosen, "latex", False))


def print_table(chosen: argparse.Namespace, table: Columns) -> None:
    """Prints a table as CSV, or for a paper as LaTeX, as the user asks."""
    print(table.to_csv() if chosen.csv else table.to_latex(), end="")


def print_json(value: Any) -> None:
    """Prints `value` on stdout as JSON."""
    from plumbob.reports.records.plain_data import json_text

    print(json_text(value))


def default_step(method: Method) -> float:
    """Returns the step [s] of a run without --step, or the relative tolerance if the method's step
    is adaptive."""
    return (method.step_sizes or (1e-3,))[-1]
