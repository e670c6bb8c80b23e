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

from plumbob.analytic.parameters import ParameterError, changed_beyond, finite, positive
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


def times(text: str) -> Array:
    """T,T,... as times [s], shape (n,), none negative; raises ParameterError."""
    instants = np.array([number("times", part) for part in text.split(",")])
    if (instants < 0.0).any():
        raise ParameterError("times", text, "0 or later")
    return instants


def changes(texts: Sequence[str] | None) -> dict[str, Any]:
    """NAME=JSON, ... as a mapping; raises ParameterError."""
    changed: dict[str, Any] = {}
    for entry in texts or ():
        name, equals, value = entry.partition("=")
        if not equals or not name:
            raise ParameterError("set", entry, "NAME=JSON")
        try:
            changed[name] = json.loads(value)
        except (ValueError, RecursionError):
            raise ParameterError(name, value, "a JSON value, such as 9.8 or [1, 2]") from None
    return changed


def jobs(chosen: argparse.Namespace) -> int:
    """How many processes; raises ParameterError."""
    return (os.cpu_count() or 1) if chosen.jobs is None else count("jobs", chosen.jobs)


@contextmanager
def workers(chosen: argparse.Namespace) -> Iterator[tuple[Executor | None, int]]:
    """An executor for tasks, a cluster's or none, and how many run at a time; raises
    ParameterError."""
    here = jobs(chosen)
    if chosen.scheduler is None:
        yield None, here
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


def print_json(value: Any) -> None:
    """Print `value` on stdout as JSON knows it."""
    from plumbob.reports.advice.json_records import plain

    json.dump(plain(value), sys.stdout, indent=1)
    print()
