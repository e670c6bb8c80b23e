"""The place of a box at which a cost is smallest, by a search that needs no derivative."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, NoAnswer
from plumbob.engines.method import Unsupported

MAX_SEARCH_RUNS = 1_000_000  # largest budget: the search keeps every run in memory
# Fraction of the runs that look everywhere in the box, and not only near the best place
WIDE_FRACTION = 0.7


@dataclass(frozen=True)
class Searched:
    """The best place that a search found."""

    place: tuple[float, ...] | None  # fractions of the sides; None if no run had a cost
    cost: float  # cost at that place
    runs: int  # number of runs made
    without: int  # number of runs whose scene has no exact answer or is unsupported: no cost
    why: str  # reason of the last run without a cost


class _Spent(Exception):
    """The budget of runs is spent."""


def lowest(
    cost: Callable[[tuple[float, ...]], float],
    sides: int,
    budget: int,
    failed: float,
    progress: Callable[[int, float], None] = lambda runs, best: None,
    first: Sequence[Sequence[float]] = (),
) -> Searched:
    """The place with the smallest `cost` that at most `budget` runs find; the `first` places are
    tried first. If a run raises NoAnswer or Unsupported, its place counts as `failed` and is never
    the answer. Raises ParameterError if the budget is too large."""
    from scipy.optimize import Bounds, direct, minimize

    if budget > MAX_SEARCH_RUNS:
        raise ParameterError("budget", budget, f"at most {MAX_SEARCH_RUNS} runs")
    tried: list[tuple[float, tuple[float, ...]]] = []  # costs with their places
    without, why = 0, ""

    def run(place: Array) -> float:
        """The cost at a place, which is moved into the box; `failed` if it has none. Raises _Spent
        if no run is left."""
        nonlocal without, why
        if len(tried) + without >= allowed_runs:
            raise _Spent
        fractions = tuple(np.clip(place, 0.0, 1.0).tolist())
        try:
            value = cost(fractions)
        except (NoAnswer, Unsupported) as reason:
            without = without + 1
            why = str(reason)
            return failed
        tried.append((value, fractions))
        progress(len(tried) + without, min(tried)[0])
        return value

    bounds = Bounds(np.zeros(sides), np.ones(sides))
    allowed_runs = max(int(WIDE_FRACTION * budget), 1)
    with suppress(_Spent):
        for place in first:
            run(np.array(place))
        direct(run, bounds, maxfun=10 * budget, maxiter=budget, vol_tol=0.0)
    allowed_runs = budget
    if not tried:
        return Searched(None, failed, without, without, why)
    start = np.array(min(tried)[1])
    with suppress(_Spent):
        options: Any = {"maxfev": budget, "xatol": 1e-9, "fatol": 0.0}
        options["initial_simplex"] = _simplex(start)
        minimize(run, start, method="Nelder-Mead", bounds=bounds, options=options)
    best, place = min(tried)
    return Searched(place, best, len(tried) + without, without, why)


def _simplex(start: Sequence[float] | Array) -> Array:
    """Corners of a simplex about a start, all within the box, shape (sides + 1, sides)."""
    start = np.asarray(start)
    steps = np.where(start > 0.5, -0.02, 0.02)
    return np.vstack([start, start + np.diag(steps)])
