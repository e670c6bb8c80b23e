"""Values of command-line arguments: numbers, lists of times, parameters as NAME=JSON."""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.analytic.parameters import (
    ParameterError,
    changed_beyond,
    finite,
    non_negative,
    positive,
)
from plumbob.analytic.reference import Array

if TYPE_CHECKING:
    from concurrent.futures import Executor

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


def positive_numbers(name: str, texts: str | Sequence[str]) -> list[float]:
    """T,T,..., or so many texts, as different numbers above zero; raises ParameterError."""
    parts = texts.split(",") if isinstance(texts, str) else texts
    return list(dict.fromkeys(positive_number(name, part) for part in parts if part))


def numbers(name: str, text: str) -> Array:
    """T,T,... as finite numbers, shape (n,); raises ParameterError."""
    return np.array([number(name, part) for part in text.split(",")])


def counts(name: str, text: str) -> list[int]:
    """N,N,... as whole numbers of 1 or more; raises ParameterError."""
    return [count(name, part) for part in text.split(",")]


def count(name: str, text: str) -> int:
    """`text` as a whole number of 1 or more, below 2^63; raises ParameterError."""
    if not (text.isascii() and text.isdigit() and len(text) < 20 and 1 <= int(text) < 2**63):
        raise ParameterError(name, text, "a whole number, 1 or more")
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


def times(name: str, text: str) -> Array:
    """T,T,... as times [s], shape (n,), none negative; raises ParameterError."""
    instants = numbers(name, text)
    if (instants < 0.0).any():
        raise ParameterError(name, text, "0 or later")
    return instants


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


def all_finite(changed: Mapping[str, Any], *answers: Mapping[str, Array]) -> None:
    """Raises ParameterError, naming what was `changed`, where an observable, or what double
    precision allows it, is not finite."""
    if changed and not all(np.isfinite(v).all() for answer in answers for v in answer.values()):
        raise changed_beyond(changed, HELD)


def show(chosen: argparse.Namespace, record: Any, template: str, /, **values: Any) -> None:
    """Print a record as JSON where that is chosen, else the lines that a template writes."""
    if chosen.json:
        print_json(record)
        return
    from plumbob.reports.view.tables import lines

    print(*lines(template, **values), sep="\n")


def print_json(value: Any) -> None:
    """Print `value` on stdout as JSON knows it."""
    from plumbob.reports.advice.json_records import plain

    json.dump(plain(value), sys.stdout, indent=1)
    print()
