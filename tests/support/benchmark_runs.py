"""Ratios of times that are taken in turn, and the file to which every run of them is added."""

import json
import math
import statistics
from dataclasses import asdict

from plumbob.reports.judge.benchmarks import FORMAT, Ratio


def in_turn(run, other, turns=21):
    """How many times as long `run` takes as `other`, each of which times itself [s], turn by turn:
    a slow spell of the machine touches both alike."""
    ratios = []
    for _ in range(turns):
        base = other()
        ratios.append(run() / base)
    return tuple(ratios)


def ratio(name, values, most=math.inf, least=0.0):
    """The ratio of some turns, at least two."""
    low, middle, high = statistics.quantiles(values, n=4, method="inclusive")
    return Ratio(name, low, middle, high, most, least)


def add(run, file):
    """Add a run to a file, which is made where there is none."""
    file.parent.mkdir(parents=True, exist_ok=True)
    ratios = [{k: v for k, v in asdict(r).items() if v != math.inf} for r in run.ratios]
    line = json.dumps({"format": FORMAT, "made": asdict(run.made), "ratios": ratios})
    with file.open("a", encoding="utf-8") as lines:
        lines.write(f"{line}\n")


def holds(of):
    """Whether the median is within its limits."""
    return of.least <= of.median <= of.most


def limit(of):
    """The limits as text."""
    if math.isfinite(of.most):
        return f"at most {of.most:g}"
    return f"at least {of.least:g}" if of.least else ""
