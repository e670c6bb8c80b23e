"""Ratios of times that are taken in turn, and their limits."""

import math
import statistics
from dataclasses import dataclass


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


def holds(of):
    """Whether the median is within its limits."""
    return of.least <= of.median <= of.most


def limit(of):
    """The limits as text."""
    if math.isfinite(of.most):
        return f"at most {of.most:g}"
    return f"at least {of.least:g}" if of.least else ""
