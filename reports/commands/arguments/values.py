"""Values of command-line arguments: numbers, lists of times, parameters as NAME=JSON."""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
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
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import scenes as find_scenes
from plumbob.reports.view.own_files import check_replaceable

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from plumbob.engines.box import Side
    from plumbob.engines.method import Method
    from plumbob.models.scene import Scene

T = TypeVar("T")
HELD = "such that double precision holds the exact solution"


def number(name: str, text: str) -> float:
    """`text` as a finite number; raises ParameterError."""
    try:
        return finite(name, float(text))
    except ValueError:
        raise ParameterError(name, text, "a finite number") from None


def positive_number(name: str, text: str) -> float:
    """`text` as a number above zero; raises ParameterError."""
    return positive(name, number(name, text))


def non_negative_number(name: str, text: str) -> float:
    """`text` as a number of zero or more; raises ParameterError."""
    return non_negative(name, number(name, text))


def each(read: Callable[[str], T], texts: str | Sequence[str]) -> list[T]:
    """T,T,..., or so many texts, as a list of values."""
    return [read(part) for part in (texts.split(",") if isinstance(texts, str) else texts)]


def count(name: str, text: str, least: int = 1) -> int:
    """`text` as a whole number of `least` or more, below 2^63; raises ParameterError."""
    if not (
        text.isascii() and text.isdigit() and len(text) < 20 and least <= int(text) < 2**63
    ):
        raise ParameterError(name, text, f"a whole number, {least} or more")
    return int(text)


def fraction(name: str, text: str) -> float:
    """5% or 0.05 as a fraction, 0 or more; raises ParameterError."""
    try:
        value = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        value = math.nan
    if not 0.0 <= value < math.inf:
        raise ParameterError(name, text, "a percentage such as 5%, or a fraction: 0.05")
    return value


def changes(argument: str, texts: Sequence[str]) -> dict[str, Any]:
    """NAME=JSON, ... as a mapping; raises ParameterError."""
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


def without(chosen: argparse.Namespace, names: Sequence[str], what: str) -> None:
    """Raises ParameterError, which says `what` it must be, where one of these options is given."""
    for name in names:
        if (value := getattr(chosen, name)) and value != "rest":
            option = "set" if name == "changes" else name.replace("_", " ")
            raise ParameterError(option, value, what)


def side(argument: str, text: str) -> Side:
    """NAME=LO:HI, or NAME=LO:HI:log, as a side of a box; raises ParameterError."""
    return _side(argument, text, "NAME=LO:HI")[0]


def counted_side(argument: str, text: str) -> tuple[Side, int]:
    """The same with :N behind HI, and N; raises ParameterError."""
    limits, number_of = _side(argument, text, "NAME=LO:HI:N")
    return limits, count(limits.name, number_of)


def _side(argument: str, text: str, form: str) -> tuple[Side, str]:
    from plumbob.engines.box import Side

    name, _, bounds = text.partition("=")
    *parts, last = bounds.split(":")
    parts += [last] * (last != "log")
    if not name or len(parts) != form.count(":") + 1:
        raise ParameterError(argument, text, f"{form}, or {form}:log")
    low, high = (number(name, part) for part in parts[:2])
    if low >= high:
        raise ParameterError(argument, text, "with the smaller value first")
    if last == "log" and low <= 0.0:
        raise ParameterError(argument, text, "above 0 where spaced by ratios")
    return Side(name, low, high, last == "log"), parts[-1]


def scenes(pattern: str, changed: Mapping[str, Any]) -> tuple[Scene, ...]:
    """The scenes of a name or pattern, with some parameters changed; raises ParameterError."""
    with representable(changed):
        if any(mark in pattern for mark in "*?[,"):
            matching = find_scenes(pattern)
            return tuple(find_scene(s.name, changed) for s in matching) if changed else matching
        return (find_scene(pattern, changed),)


def html_file(name: str, text: str) -> Path:
    """A file .html that can be written; raises ParameterError with the `name` of the option."""
    file = Path(text)
    check_replaceable(name, file)
    if file.suffix != ".html" or not os.access(file.parent, os.W_OK):
        raise ParameterError(name, text, "a file .html in a folder that can be written to")
    return file


@contextmanager
def workers(chosen: argparse.Namespace) -> Iterator[tuple[Executor | None, int]]:
    """An executor for tasks, a cluster's or none, and how many run at a time; raises
    ParameterError."""
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
    """Raises ParameterError, naming what was `changed`, where the exact solution fails in double
    precision: the extremes of some parameters overflow; and, given all arguments `chosen`, where an
    error names neither that nor one of them."""
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
        raise changed_beyond(changed, HELD) from error


def all_finite(changed: Mapping[str, Any], *answers: Signals) -> None:
    """Raises ParameterError, naming what was `changed`, where an observable, or what double
    precision allows it, is not finite."""
    if changed and not all(np.isfinite(v).all() for answer in answers for v in answer.values()):
        raise changed_beyond(changed, HELD)


def show(chosen: argparse.Namespace, record: Any, template: str, /, **values: Any) -> None:
    """Print a record as JSON where that is chosen, else the lines that a template writes."""
    if chosen.json:
        print_json(record)
        return
    from plumbob.reports.view.tables import terminal_lines

    print(*terminal_lines(template, **values), sep="\n")


def print_json(value: Any) -> None:
    """Print `value` on stdout as JSON knows it."""
    from plumbob.reports.records.plain_data import FOR_JSON, plain

    json.dump(plain(value, FOR_JSON), sys.stdout, indent=1)
    print()


def default_step(method: Method) -> float:
    """The step [s], or tolerance, of a run unless another is asked for."""
    return (method.step_sizes or (1e-3,))[-1]
