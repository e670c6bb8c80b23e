"""Benchmarks: ratios of times that are taken in turn, as a file keeps every run of them."""

from __future__ import annotations

import json
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study.provenance import Provenance

FORMAT = "plumbob benchmarks 1"
START = f'{{"format": "{FORMAT}"'  # of each line
LARGEST = 50_000_000  # [bytes] of a file: tens of thousands of runs


@dataclass(frozen=True)
class Ratio:
    """How many times as long one thing takes as another: the median of many turns, the quartiles,
    and what the median has to stay within."""

    name: str
    low: float
    median: float
    high: float
    most: float = math.inf
    least: float = 0.0


@dataclass(frozen=True)
class BenchmarkRun:
    """The ratios measured in one run, and its provenance."""

    made: Provenance
    ratios: tuple[Ratio, ...]


def keeps_benchmarks(file: Path) -> bool:
    """Whether a file is one of benchmarks, by how it begins."""
    try:
        if not file.is_file():
            return False
        with file.open("rb") as lines:
            return lines.read(len(START)) == START.encode()
    except OSError:
        return False


def stored(file: Path) -> tuple[BenchmarkRun, ...]:
    """The runs of a file, the oldest first; raises ParameterError for a line that is damaged."""
    if (size := os.stat(file).st_size) > LARGEST:
        raise ParameterError("benchmarks", f"{file} ({size} bytes)", f"at most {LARGEST} bytes")
    runs = []
    for number, line in enumerate(file.read_text("utf-8", errors="replace").splitlines(), 1):
        try:
            runs.append(_run(json.loads(line)))
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            what = "a run of benchmarks, as `make benchmark` writes it"
            raise ParameterError("benchmarks", f"{file}, line {number}", what) from None
    return tuple(runs)


def _run(entry: Any) -> BenchmarkRun:
    ratios = tuple(Ratio(**ratio) for ratio in entry["ratios"])
    if not all(0.0 < value < math.inf for r in ratios for value in (r.low, r.median, r.high)):
        raise ValueError("a ratio of times is positive")
    return BenchmarkRun(Provenance(**entry["made"]), ratios)


def moved(old: BenchmarkRun, new: BenchmarkRun, factor: float) -> tuple[tuple[Ratio, Ratio], ...]:
    """The ratios of both runs of which the quartiles are apart, and the medians by more than a
    factor."""
    before = {r.name: r for r in old.ratios}
    pairs = [(before[r.name], r) for r in new.ratios if r.name in before]
    return tuple(
        (was, now)
        for was, now in pairs
        if (now.low > was.high or now.high < was.low)
        and max(now.median / was.median, was.median / now.median) > factor
    )
